# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an effect adds to what is free, and which effects say nothing new beside others."""

from dataclasses import replace

from made_task import P, everywhere, problem_of, seen
import pytest

from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, label
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import redundant, with_effects
from booster_ros.model.catalogue import EFFECTS, has_part
from booster_ros.model.parameters import from_values


@pytest.mark.parametrize(('name', 'present', 'said'), [
    ('stem_friction', (), False),
    ('stem_friction', ('chamber_leak',), False),
    ('stem_friction', ('stem_friction',), True),
    ('stem_friction', ('position_dependent_friction',), False),  # which has no stiction
    ('position_dependent_friction', ('stem_friction',), False),
])
def test_what_has_no_parameter_of_its_own_is_redundant(name, present, said):
    assert redundant(name, present) is said


def test_each_parameter_is_free_once():
    problem = problem_of(seen(P), 'stem_friction', 'position_dependent_friction')
    names = [(free.knob.parameter, free.element) for free in problem.freedoms]
    assert len(names) == len(set(names))
    assert {knob.parameter for knob in EFFECTS['stem_friction'].knobs if not knob.shape} <= {
        name for name, _ in names}
    assert with_effects(problem, ('stem_friction',)).freedoms == problem.freedoms


def test_beside_an_effect_that_loosens_them_declared_parameters_have_wider_priors():
    experiment = seen(P)
    alone, beside = (problem_of(experiment, *names) for names in ((), ('ep_nonlinearity',)))
    wider = [free.knob.parameter for before, free in zip(alone.freedoms, beside.freedoms)
             if free.sigma > before.sigma]
    assert 'ep_converter.gain' in wider
    assert 'actuator.effective_area' not in wider


def test_another_firmware_has_its_own_law_and_its_own_tuning():
    declared = from_values({'position_controller.enabled': True})
    experiment = replace(seen(P), command='set_point')
    problem = Problem(experiment, everywhere(experiment), declared,
                      tuple(declared_freedom(declared, experiment)))
    joint = with_effects(problem, ('pulsing_firmware',))
    assert [label(f) for f in joint.freedoms[:len(problem.freedoms)]] == [
        label(f) for f in problem.freedoms]
    given = dict(EFFECTS['pulsing_firmware'].sets)
    controller = joint.parameters(joint.start()).position_controller
    for name in ('output', 'gain', 'integral_time', 'derivative_time'):
        assert getattr(controller, name) == given[f'position_controller.{name}']
    # of its gain as much is known as of the declared one's, in proportion, of no integral part all
    z = joint.start()
    _, high = joint.bounds()
    for j, free in enumerate(joint.freedoms):
        if free.knob.parameter in ('position_controller.gain', 'position_controller.integral_time'):
            z[j] = high[j]
    tuned = joint.parameters(z).position_controller
    assert tuned.gain == pytest.approx(1.5 * given['position_controller.gain'])
    assert tuned.integral_time == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(('values', 'own'), [
    ({}, 'integrating_firmware'), ({'integral_time': 0.0}, 'proportional_firmware'),
    ({'output': 'pulses'}, 'pulsing_firmware')])
def test_a_firmware_is_no_other_than_itself(values, own):
    p = from_values({f'position_controller.{name}': value for name, value in values.items()})
    firmwares = [name for name, effect in EFFECTS.items() if effect.sets]
    assert len(firmwares) == 3
    assert [name for name in firmwares if not has_part(p, EFFECTS[name])] == [own]
