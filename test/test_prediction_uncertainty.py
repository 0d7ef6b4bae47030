# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a record leaves open of its model, and what that does to what the model predicts."""

from dataclasses import replace

from made_task import (
    CURRENT, P, RAMPS, RAMPS_TIME, START_PRESSURE, STEPS, TIME, everywhere, seen, steps_seen)
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import FEWEST
from booster_ros.diagnosis.estimation.final_fit import FinalFit
from booster_ros.diagnosis.estimation.fit import fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, label, put
from booster_ros.diagnosis.estimation.uncertainty import block_bootstrap
from booster_ros.diagnosis.judging.prediction_uncertainty import (
    MODELS, models_alike, with_left_open)
from booster_ros.diagnosis.result import ChannelError, errors_of

MILD = np.array([3.9, 4.0, 3.95, 4.05, 4.0, 4.1, 4.05, 4.0, 3.95, 3.9])
LARGE = np.array([4.6, 3.4, 4.4, 3.5, 4.6, 3.4])
"""Steps (0.1 mA) that open no seat of the booster as far as it goes, and steps that do."""


def errors(experiment, run):
    return errors_of(experiment, dict.fromkeys(('declared', 'before', 'after'), run),
                     everywhere(experiment))


def test_what_is_left_open_is_the_root_mean_square_of_what_models_differ_by():
    experiment = seen(P)
    run = experiment.predict(P)
    start = experiment.initial

    def off_by(*pressures):
        return tuple((put(P, 'sensors.pressure_bias', one), start) for one in pressures)

    models = off_by(300.0, -400.0)
    found = with_left_open(
        errors(experiment, run), experiment, run, models, everywhere(experiment), start)
    pressure, position = found['chamber_pressure'], found['valve_position']
    assert pressure.left_open == pytest.approx(np.sqrt((300.0**2 + 400.0**2) / 2.0), rel=1e-6)
    assert position.left_open == 0.0
    assert errors(experiment, run)['chamber_pressure'].after == pressure.after
    turned = replace(experiment, measured=dict(reversed(experiment.measured.items())))
    again = with_left_open(errors(turned, run), turned, run, models, everywhere(turned), start)
    assert str(again['chamber_pressure']) == str(pressure)


def test_all_models_begin_where_they_are_told_to_or_each_in_its_own_start():
    experiment = seen(P)
    run = experiment.predict(P)
    models = ((P, replace(experiment.initial, chamber_pressure=START_PRESSURE + 5e3)),)
    told, own = (with_left_open(errors(experiment, run), experiment, run, models,
                                everywhere(experiment), start)['chamber_pressure'].left_open
                 for start in (experiment.initial, None))
    assert told == 0.0
    assert own > 100.0


def test_rows_that_do_not_count_and_channels_without_a_value_leave_nothing_open():
    experiment = seen(P)
    later = experiment.time > 10.0
    experiment = replace(experiment, measured=experiment.measured | {
        'valve_position': np.full(len(later), np.nan)})
    run = experiment.predict(P)
    drifting = put(P, 'ep_converter.drift', 1e3)
    models = ((drifting, experiment.initial),)
    early, late = (with_left_open(errors(experiment, run), experiment, run, models, rows)
                   for rows in (~later, later))
    assert late['chamber_pressure'].left_open > 1.5 * early['chamber_pressure'].left_open
    assert np.isnan(late['valve_position'].left_open)
    nowhere = np.zeros(len(later), dtype=bool)
    none = with_left_open(errors_of(experiment, dict.fromkeys(('declared', 'before', 'after'), run),
                                    nowhere), experiment, run, models, nowhere)
    assert all(np.isnan(error.left_open) for error in none.values())


def fitted(experiment, known=()):
    """Return the declared model fitted to all rows, but for parameters that are known."""
    problem = Problem(experiment, everywhere(experiment), P, tuple(
        free for free in declared_freedom(P, experiment) if free.knob.parameter not in known))
    found = fit(problem)
    return FinalFit(problem, found, block_bootstrap(problem, found, (
        experiment.time // 3.0).astype(int)))


@pytest.fixture(scope='module')
def as_declared():
    """Return the fit of the declared model to a valve that is as declared."""
    return fitted(seen(P, time=TIME[::3], current=CURRENT[::3]))


def judged(other, last, models):
    """Return the errors of the fitted model on another experiment, with what is left open there."""
    run = other.predict(last.fit.parameters)
    return with_left_open(
        errors(other, run), other, run, models, everywhere(other), other.initial)


def test_what_no_step_of_a_record_needed_is_open_where_another_one_needs_it():
    """And a valve whose largest area is off by a tolerance misses by about as much."""
    mild = steps_seen(P, MILD, START_PRESSURE, seed=1)
    last = fitted(mild, ('booster.critical_pressure_ratio',))
    models = models_alike(last)
    assert len(models) == MODELS
    other = steps_seen(P, LARGE, START_PRESSURE, seed=2)
    run = other.predict(last.fit.parameters)
    for name, error in judged(other, last, models).items():
        assert error.met  # this valve is as declared
        off = [other.predict(put(P, 'booster.max_area', share * P.booster.max_area))[name]
               for share in (0.94, 1.06)]
        missed = np.sqrt(np.mean((np.array(off) - run[name])**2))
        assert 0.5 < error.left_open / missed < 1.6
    again = judged(mild, last, models)
    assert all(error.left_open < 0.1 * error.noise for error in again.values())


def drawn_valve(seed):
    """Return a valve that is off by what its declared parameters may be."""
    rng = np.random.default_rng(seed)
    valve = P
    for free in declared_freedom(P, seen(P)):
        z = float(np.clip(free.sigma * rng.standard_normal(), free.low, free.high))
        valve = put(valve, free.knob.parameter, free.value(z), free.element)
    return valve


@pytest.mark.campaign
def test_valves_are_missed_by_as_much_as_is_left_open_unless_much_is_missing():
    """Of valves drawn from the tolerances; each is known by ramps, and judged on large steps."""
    ratios, foreseen, excused = [], [], []
    for seed in range(8):
        valve = drawn_valve(seed)
        last = fitted(seen(
            valve, None, START_PRESSURE, RAMPS[:3000], seed, RAMPS_TIME[:3000]))
        models = models_alike(last)
        found = judged(steps_seen(valve, LARGE, START_PRESSURE, 100 + seed), last, models)
        ratios += [np.sqrt(max(error.after**2 - error.noise**2, 0.0)) / error.left_open
                   for error in found.values()]
        foreseen.append(all(error.foreseen for error in found.values()))
        ill = steps_seen(put(valve, 'actuator.leak_area', 4e-7), LARGE, START_PRESSURE, 200 + seed)
        excused += [error.foreseen for error in judged(ill, last, models).values()]
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.4
    assert sum(foreseen) >= 7  # of 95 %
    assert not any(excused)


def test_what_a_record_has_shown_is_open_no_more():
    last = fitted(steps_seen(P, np.r_[STEPS[:4], LARGE], START_PRESSURE, seed=1))
    other = steps_seen(P, LARGE[::-1], START_PRESSURE, seed=2)
    found = judged(other, last, models_alike(last))
    assert all(0.0 < error.left_open < 0.3 * error.noise for error in found.values())


def test_draws_that_miss_what_was_fitted_are_no_models_of_it(as_declared, monkeypatch):
    last, runs, cost = as_declared, [], Problem.cost
    monkeypatch.setattr(Problem, 'cost', lambda self, z: runs.append(z) or cost(self, z))
    gain = [label(free) for free in last.problem.freedoms].index('ep_converter.gain')
    near, far = np.tile(last.fit.z, (160, 1)), np.tile(last.fit.z, (160, 1))
    far[:, gain] += 1.0  # a tolerance, 2 %, of what a record tells to parts of a thousand
    mixed = near.copy()
    mixed[::8] = far[::8]
    assert len(models_alike(replace(last, draws=near))) == MODELS
    runs.clear()
    assert models_alike(replace(last, draws=far)) is None
    assert len(runs) == 2 * MODELS  # where none of so many suits, too few of all will
    seldom = far.copy()
    seldom[::10] = last.fit.z
    assert len(models_alike(replace(last, draws=seldom))) == 16
    few = far.copy()
    few[:4 * (FEWEST - 1):4] = last.fit.z
    assert models_alike(replace(last, draws=few)) is None
    kept = models_alike(replace(last, draws=mixed))
    assert len(kept) == MODELS
    assert {p.ep_converter.gain for p, _ in kept} == {last.fit.parameters.ep_converter.gain}


def test_where_nothing_is_known_of_other_models_the_errors_stay_as_they_are():
    experiment = seen(P)
    run = experiment.predict(P)
    assert with_left_open(errors(experiment, run), experiment, run, None,
                          everywhere(experiment)) == errors(experiment, run)


def test_no_model_is_beyond_the_bounds(as_declared):
    last = as_declared
    limit = [label(free) for free in last.problem.freedoms].index('booster.max_area')
    draws = np.tile(last.fit.z, (400, 1))
    draws[:, limit] += np.where(np.arange(400) % 8 < 4, 0.0, 99.0)
    models = models_alike(replace(last, draws=draws))
    highest = last.problem.freedoms[limit].knob.high
    assert max(p.booster.max_area for p, _ in models) == pytest.approx(highest)


def test_what_is_missed_is_compared_with_the_size_of_what_is_left_open():
    rubbing = put(put(P, 'actuator.coulomb_friction', 400.0), 'actuator.stiction', 100.0)
    experiment = seen(P)
    run = experiment.predict(P)
    errors_of_run = errors(experiment, run)
    left = {name: replace(error, after=1.5 * error.noise)
            for name, error in errors_of_run.items()}
    models = ((rubbing, experiment.initial),)
    for error in with_left_open(left, experiment, run, models, everywhere(experiment),
                                      experiment.initial).values():
        much = error.left_open > 1.2 * error.noise
        assert error.unforeseen == pytest.approx(
            error.noise if much else np.sqrt(1.5**2 * error.noise**2 - 4.0 * error.left_open**2))
        assert error.foreseen


@pytest.mark.parametrize(('after', 'unforeseen', 'met', 'foreseen'), [
    (1.2, 9.0, True, True), (1.5, np.nan, False, False), (1.5, 1.4, False, False),
    (3.0, 1.1, False, True), (np.nan, np.nan, False, False)])
def test_an_error_is_foreseen_where_noise_is_left_beyond_what_is_open(
        after, unforeseen, met, foreseen):
    error = ChannelError('Pa', 9.0, 9.0, after, 1.0, 2.0, unforeseen)
    assert (error.met, error.foreseen) == (met, foreseen)
