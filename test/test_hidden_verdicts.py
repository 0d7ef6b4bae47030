# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effects that the hidden plant has, some of which no catalogue knows: what close_loop makes of them.

Each is minutes of work together: all but one only with BOOSTER_ROS_ALL_SAMPLES in the environment.
"""

import json
import os

from hidden_plant.cases import Case, write_cases
import pytest

from booster_ros.programs.close_loop import main

slow = pytest.mark.skipif(
    'BOOSTER_ROS_ALL_SAMPLES' not in os.environ, reason='minutes: BOOSTER_ROS_ALL_SAMPLES=1')


def verdict_on(effects, folder, seed):
    """Return what the key says of a plant with these effects, and close_loop's report on it."""
    case = Case('case', tuple(effects), seed=seed)
    list(write_cases([case], folder))
    status = main(['--record', str(folder / 'case_fit.csv'), '--params', str(folder / 'case.yaml'),
                   '--validation', str(folder / 'case_val.csv'), '--out', str(folder / 'out')])
    assert status == 0
    key = json.loads((folder / 'key.json').read_text())['case']
    return key, json.loads((folder / 'out' / 'report.json').read_text())


def places(report):
    return {effect['location'] for effect in report['effects']}
