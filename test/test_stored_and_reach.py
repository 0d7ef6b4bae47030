# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What preparing says of channels that were stored by exception, or go where the valve cannot."""

from dataclasses import dataclass, field

from made_diagnosis import DECLARED
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.reach import out_of_reach
from booster_ros.diagnosis.prepare.stored_by_exception import with_limits_of_storing


@dataclass(frozen=True)
class WithNoise:
    """What an experiment has that is looked at here."""

    noise: dict[str, float] = field(default_factory=dict)


def test_held_values_show_no_noise_but_are_known_to_their_limit_alone():
    told = with_limits_of_storing(
        WithNoise({'chamber_pressure': 5.0, 'valve_position': 1e-5}),
        {'chamber_pressure': 300.0, 'valve_position': 1e-7, 'control_current': 1e-5})
    assert told.noise == {
        'chamber_pressure': pytest.approx(300.0 / np.sqrt(3.0)), 'valve_position': 1e-5}


@pytest.mark.parametrize(('name', 'share', 'said'), [
    ('chamber_pressure', 1.04, False), ('chamber_pressure', 1.2, True),
    ('back_pressure', 1.2, True), ('valve_position', 1.04, False), ('valve_position', 1.2, True),
    ('valve_position', -0.2, True)])
def test_what_the_declared_valve_cannot_reach_is_said(name, share, said):
    full = DECLARED.actuator.travel if name == 'valve_position' else DECLARED.supply.pressure
    notes = out_of_reach({name: share * full * np.linspace(0.0, 1.0, 1000)}, DECLARED)
    assert bool(notes) is said
    assert all(note.startswith(name) for note in notes)
