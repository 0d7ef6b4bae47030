# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""However a positioner is told to end, and however often, it ends cleanly."""

import signal
import time

from positioner_process import start
import pytest
from ros_process import HANGUP, RosProcess, program


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, HANGUP])
def test_a_signal_that_comes_again_and_again_ends_it_with_status_0(number):
    """The gaps between them are those between which a node ended in an error without its guards."""
    with start('-p', 'publish_rate:=1000.0') as node:
        for gap in (0.0, 1e-3, 3e-3, 1e-2, 1e-3, 3e-3, 1e-2):
            node.send(number)
            time.sleep(gap)
        assert node.wait() == 0
        assert 'Traceback' not in node.output
        assert 'Exception' not in node.output


def test_under_nohup_it_outlives_its_terminal():
    with RosProcess(['nohup', *program('positioner')]) as node:
        node.wait_for('ticks per second')
        node.send(signal.SIGHUP)
        with pytest.raises(AssertionError, match='still running'):
            node.wait(1.0)
        assert node.interrupt() == 0
