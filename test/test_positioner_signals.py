# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""However a positioner is told to end, and however often, it ends cleanly."""

import signal
import time

from positioner_process import start
import pytest


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('gap', [0.0, 1e-3, 3e-3, 1e-2])
def test_a_signal_that_comes_three_times_ends_it_with_status_0(number, gap):
    with start('-p', 'publish_rate:=1000.0') as node:
        for _ in range(3):
            node.send(number)
            time.sleep(gap)
        assert node.wait() == 0
        assert 'Traceback' not in node.output
        assert 'Exception' not in node.output
