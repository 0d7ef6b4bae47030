# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands that the valve took somewhere between two rows."""

from made_diagnosis import DECLARED
from made_record import misfits
import numpy as np

from booster_ros.model.simulation import simulate


def test_commands_between_the_stamps_of_another_clock_are_no_effect():
    """A record without noise; each command is taken up to half a row before or after its row."""
    rng = np.random.default_rng(3)
    fine = 0.001 * np.arange(40_000)
    wanted = np.where(fine % 4.0 < 2.0, 0.43e-3, 0.45e-3)
    taken = wanted.copy()
    for change in np.flatnonzero(np.diff(wanted)) + 1:
        by = int(rng.integers(-5, 6))
        taken[min(change, change + by):max(change, change + by)] = wanted[change - (by > 0)]
    run = simulate(DECLARED, fine, taken, {'chamber_pressure': 170e3})
    rows = np.arange(0, 40_000, 10) + rng.integers(0, 3, 4000)
    columns = {'time': fine, 'control_current': wanted,
               'chamber_pressure': run['chamber_pressure'], 'valve_position': run['valve_position']}
    for misfit in misfits({name: values[rows] for name, values in columns.items()}).values():
        assert 0.1 < misfit < 2.0
