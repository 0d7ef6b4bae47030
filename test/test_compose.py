# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an effect adds to what is free, and which effects say nothing new beside others."""

from made_task import P, problem_of, seen
import pytest

from booster_ros.diagnosis.hypotheses.compose import redundant, with_effects
from booster_ros.model.catalogue import EFFECTS


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
