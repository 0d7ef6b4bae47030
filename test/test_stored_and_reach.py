# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What preparing says of channels that were stored by exception, or go where the valve cannot."""

from dataclasses import replace

from made_diagnosis import DECLARED
from made_record import record_of, step_test
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.plausibility import out_of_reach
from booster_ros.diagnosis.prepare.preparation import prepare


def test_held_values_show_no_noise_but_are_known_to_their_limit_alone():
    record = record_of(**step_test())
    seen = prepare(record, DECLARED)
    told = prepare(replace(record, held={
        'chamber_pressure': 600.0, 'valve_position': 1e-7, 'control_current': 1e-5}), DECLARED)
    assert told.noise == {
        'chamber_pressure': pytest.approx(600.0 / np.sqrt(3.0)),
        'valve_position': seen.noise['valve_position']}


@pytest.mark.parametrize(('name', 'share', 'said'), [
    ('chamber_pressure', 1.04, False), ('chamber_pressure', 1.2, True),
    ('back_pressure', 1.2, True), ('valve_position', 1.04, False), ('valve_position', 1.2, True),
    ('valve_position', -0.2, True)])
def test_what_the_declared_valve_cannot_reach_is_said(name, share, said):
    full = DECLARED.actuator.travel if name == 'valve_position' else DECLARED.supply.pressure
    notes = out_of_reach({name: share * full * np.linspace(0.0, 1.0, 1000)}, DECLARED)
    assert bool(notes) is said
    assert all(note.startswith(name) for note in notes)
