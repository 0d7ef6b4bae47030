# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What lies above a stem that sticks is held, and how sure it is carries over to all else."""

from dataclasses import replace
from types import SimpleNamespace

from made_task import P, place_of, problem_of, seen, task_of, z_of
import numpy as np
import pytest

from booster_ros.diagnosis import pipeline
from booster_ros.diagnosis.estimation.final_fit import FinalFit
from booster_ros.diagnosis.estimation.fit import fit, fit_at
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.estimation.two_steps import in_two_steps
from booster_ros.diagnosis.estimation.uncertainty import DRAWS
from booster_ros.diagnosis.hypotheses.subsystem import upstream

LEAK, SHIFT = 'actuator.leak_area', 'actuator.bench_set_shift'
SPREAD = 0.02


@pytest.fixture(scope='module')
def leaking():
    """Return the experiment of a leak beside a shifted bench set."""
    return seen(put(put(P, LEAK, 3e-8), SHIFT, 2e3))


def told(experiment, leak):
    """Return what the part above the stem says of the leak, with draws that spread by SPREAD."""
    problem = problem_of(upstream(experiment), 'chamber_leak', freedoms=())
    found = fit_at(problem, z_of(problem, {LEAK: leak}))
    draws = np.tile(found.z, (DRAWS, 1))
    draws[:, 0] += SPREAD * np.random.default_rng(3).standard_normal(DRAWS)
    return FinalFit(problem, found, draws)


@pytest.mark.parametrize('leak', [3e-8, 4e-8])
def test_all_else_goes_along_with_what_is_held_as_a_fit_would(leaking, leak):
    problem = problem_of(leaking, 'chamber_leak', 'bench_set_shift', freedoms=())
    blocks = np.arange(len(leaking.time)) // 150
    last = in_two_steps(problem, problem.start(), blocks, told(leaking, leak))
    z, held, shift = last.fit.z, place_of(problem, LEAK), place_of(problem, SHIFT)
    assert last.fit.parameters.actuator.leak_area == pytest.approx(leak)
    assert np.std(last.draws[:, held]) == pytest.approx(SPREAD, rel=0.1)
    # where the leak is that much larger, a fit of all else ends where the draws have it
    further, others = z.copy(), np.setdiff1d(np.arange(len(z)), [held])
    further[held] += SPREAD
    further[others] = fit(problem.holding(further, [held]), [z[others]], tolerance=1e-6).z
    off = last.draws - z
    carried = SPREAD * (off[:, held] @ off[:, shift]) / (off[:, held] @ off[:, held])
    assert abs(carried) > 1e-3
    assert carried == pytest.approx(further[shift] - z[shift], rel=0.25)


@pytest.mark.parametrize(('effects', 'measured', 'steps'), [
    (('chamber_leak', 'stem_friction'), ('chamber_pressure', 'valve_position'), 2),
    (('position_backlash', 'stem_friction'), ('chamber_pressure', 'valve_position'), 1),
    (('stem_friction',), ('valve_position',), 1),
    (('chamber_leak',), ('chamber_pressure', 'valve_position'), 1)])
def test_a_stem_that_sticks_and_is_seen_as_it_is_takes_two_steps(
        leaking, effects, measured, steps, monkeypatch):
    experiment = replace(leaking, measured={name: leaking.measured[name] for name in measured})
    task = task_of(experiment, freedoms=())
    fits = []

    def fitted(problem, begin, block_of_row, above=None):
        fits.append((problem, above))
        return SimpleNamespace(problem=problem)

    monkeypatch.setattr(pipeline, 'final_fit', fitted)
    monkeypatch.setattr(pipeline, 'in_two_steps', fitted)
    problem = task.problem(effects)
    model = SimpleNamespace(effects=effects, problem=problem, fit=fit_at(problem, problem.start()))
    pipeline._last_fit(task, model, np.zeros(len(experiment.time)))
    (*above, (whole, told_above)) = fits
    assert len(fits) == steps
    assert [free.knob.parameter for free in whole.freedoms] == [
        free.knob.parameter for free in problem.freedoms]
    if above:
        assert told_above.problem.experiment.pinned  # driven by the measured stem
        assert [free.knob.parameter for free in told_above.problem.freedoms] == [LEAK]
