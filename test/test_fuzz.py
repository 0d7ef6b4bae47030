# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A few of the inputs of `python -m fuzz`: each reader, preparing and the plant bear them."""

import random
import signal

from fuzz.__main__ import TARGETS, hang, run
import pytest

INPUTS = {'bag': 100, 'csv': 100, 'mapped': 100, 'mapping_file': 100, 'parameter_file': 100,
          'plant': 300, 'preparing': 40}


@pytest.mark.parametrize('target', TARGETS)
def test_what_nobody_would_write_is_answered(target):
    before = signal.signal(signal.SIGVTALRM, hang)
    try:
        run(target, 0, INPUTS[target])
    finally:
        signal.signal(signal.SIGVTALRM, before)


def test_an_input_that_fails_is_named(monkeypatch):
    def fails(rng: random.Random) -> None:
        assert rng.random() >= 0.0
        raise IndexError('out of range')

    monkeypatch.setitem(TARGETS, 'plant', fails)
    with pytest.raises(AssertionError, match='plant, input 7: IndexError'):
        run('plant', 7, 1)
