# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a real valve would give a twin: noisy readings of a valve whose current steps at random."""

import numpy as np

from booster_ros.model.parameters import from_values
from booster_ros.model.stream import Stream


def moving_valve(values, seconds, rate, dwell, seed=0, low=0.4e-3, high=0.46e-3):
    """
    Return columns of a valve with these parameters, `rate` a second, a step each `dwell` s.

    Steps go to currents from `low` to `high`, A.
    """
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    current = low + (high - low) * random.random(len(time))[(time / dwell).astype(int)]
    seen = Stream(from_values(dict(values)), 0.0, current[0], {'chamber_pressure': 2e5}).advance(
        time, current)
    return {
        'time': time, 'control_current': current,
        **{name: seen[f'measured_{name}'] + noise * random.standard_normal(len(time))
           for name, noise in (('chamber_pressure', 150.0), ('valve_position', 8e-6))},
    }
