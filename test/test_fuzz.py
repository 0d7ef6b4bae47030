# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A few of the inputs of `python -m fuzz`: each reader, preparing and the plant bear them."""

import os
import random
import signal
import subprocess
import sys

from fuzz.__main__ import TARGETS, hang, run
import pytest
from ros_process import ROOT

INPUTS = {'bag': 40, 'csv': 100, 'mapped': 40, 'mapping_file': 100, 'parameter_file': 100,
          'plant': 100, 'preparing': 20}

ALONE = {'bag', 'mapped'}
"""Targets whose files are read by libraries in C: what a damaged one does to their memory must not
reach other tests."""


@pytest.mark.parametrize('target', sorted(ALONE))
def test_what_others_would_not_write_is_answered_by_libraries_in_c(target):
    done = subprocess.run(
        [sys.executable, '-m', 'fuzz', target, '--inputs', str(INPUTS[target])], timeout=300,
        env={**os.environ, 'PYTHONPATH': f'{ROOT}{os.pathsep}{ROOT / "test"}'},
        capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert f'{target}: {INPUTS[target]} inputs' in done.stdout


@pytest.mark.parametrize('target', sorted(TARGETS.keys() - ALONE))
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
