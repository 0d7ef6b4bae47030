# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is seen above the stem, with its measured position as what drives the chamber."""

from made_effect import add_effect
from made_task import LEAKING, P, RUBBING, searching, seen, standing_at
import numpy as np
import pytest

from booster_ros.diagnosis.hypotheses.subsystem import (
    above_the_stem, as_seen_above, shows_above_the_stem)


def test_above_the_stem_friction_does_not_matter_but_a_leak_shows():
    rubbing = P._replace(actuator=P.actuator._replace(coulomb_friction=400.0, stiction=150.0))
    leaking = rubbing._replace(actuator=rubbing.actuator._replace(leak_area=4e-8))

    def misfit(plant, model):
        above = above_the_stem(seen(plant))
        assert set(above.measured) == {'chamber_pressure'}
        predicted = above.predict(model)['chamber_pressure']
        difference = above.measured['chamber_pressure'] - predicted
        return float(np.mean((difference[200:] / 150.0) ** 2))  # without the first rush

    settled = seen(rubbing)
    whole = settled.predict(P)['chamber_pressure'] - settled.measured['chamber_pressure']
    blurred = np.mean((whole[200:] / 150.0) ** 2)
    blameless = misfit(rubbing, P)
    assert blameless < blurred / 20.0
    assert misfit(leaking, P) > 20.0 * blameless


def test_a_record_without_position_has_nothing_above_its_stem():
    experiment = seen(P)
    del experiment.measured['valve_position']
    assert above_the_stem(experiment) is None


@pytest.mark.parametrize(('effect', 'shows'), [
    ('supply_droop', True), ('chamber_leak', True), ('pressure_sensor_lag', True),
    ('stem_friction', False), ('position_backlash', False)])
def test_effects_above_the_stem(effect, shows):
    assert shows_above_the_stem(effect) is shows


@pytest.mark.parametrize(('reading', 'shows'), [
    ('chamber_pressure', True), ('valve_position', False)])
def test_a_new_effect_of_a_sensor_shows_above_the_stem_by_its_reading(monkeypatch, reading, shows):
    add_effect(monkeypatch, 'loose_screw', 'sensor', reading=reading)
    assert shows_above_the_stem('loose_screw') is shows


def test_what_lies_above_a_stem_that_sticks_is_taken_from_there():
    search = searching(seen(LEAKING), ())
    bent = standing_at(search, ('stem_friction', 'chamber_leak'), {
        **RUBBING, 'ep_converter.offset': 5e3, 'actuator.leak_area': 1e-8,
        'actuator.viscous_friction': 4000.0})
    z = as_seen_above(search, bent, bent.fit.z, ('fit',))
    p = bent.problem.parameters(z)
    assert abs(p.ep_converter.offset) < 500.0
    assert p.actuator.leak_area == pytest.approx(4e-8, rel=0.1)
    # of the stem itself viscous friction goes back, which may have stood in for the other kind
    assert p.actuator.viscous_friction == pytest.approx(P.actuator.viscous_friction)
    assert p.actuator.coulomb_friction == pytest.approx(400.0)
    assert p.actuator.stiction == pytest.approx(100.0)
    elsewhere = standing_at(search, bent.effects, {
        **RUBBING, 'actuator.coulomb_friction': 250.0}).fit.z
    p = bent.problem.parameters(as_seen_above(search, bent, elsewhere, ('fit',)))
    assert p.actuator.coulomb_friction == pytest.approx(400.0, rel=0.03)
    smooth = standing_at(search, ('chamber_leak',), {'ep_converter.offset': 5e3})
    assert (as_seen_above(search, smooth, smooth.fit.z, ('fit',)) == smooth.fit.z).all()
