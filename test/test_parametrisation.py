# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Within which bounds parameters are fitted, what loosens them, and which end at a limit."""

from types import SimpleNamespace

from made_diagnosis import DECLARED, record_of, timed_columns
from made_record import flow_bench
from made_task import P, seen
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Initial
from booster_ros.diagnosis.estimation.final_fit import FinalFit
from booster_ros.diagnosis.estimation.fit import Fit, fit
from booster_ros.diagnosis.estimation.parametrisation import (
    BENCH, BENCH_RANGE, declared_freedom, get, loosened, put)
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.diagnosis.pipeline import _refitted, diagnose
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.catalogue import EFFECTS
from booster_ros.report.notes import notes


def test_the_range_of_a_bench_holds_no_place_where_its_parameters_stand_still():
    for name in BENCH:
        free = next(f for f in declared_freedom(DECLARED, flow_bench(7e-6, 0.37))
                    if f.knob.parameter == name)
        given = get(DECLARED, name)
        assert free.value(free.low) == pytest.approx(BENCH_RANGE * given)
        assert free.value(free.high) == pytest.approx(given / BENCH_RANGE)
        assert free.value(free.low + 1e-3) < 0.99 * free.value(free.low)


def test_stops_may_hardly_yield_but_not_be_as_soft_as_a_seat():
    name = 'actuator.stop_stiffness'
    free = next(f for f in declared_freedom(DECLARED, seen(P)) if f.knob.parameter == name)
    assert free.value(free.low) == pytest.approx(10.0 * get(DECLARED, name))
    assert get(DECLARED, name) / 3.0 < free.value(free.high) < get(DECLARED, name) / 2.0


def test_beside_what_loosens_it_a_parameter_has_its_own_limit():
    """A gain 12 % off is at the end of a usual refit, and not of one beside a bent curve."""
    free = next(one for one in declared_freedom(P, prepare(record_of(timed_columns()), P))
                if one.knob.parameter == 'ep_converter.gain')
    bent = EFFECTS['ep_nonlinearity']
    looser = loosened(free, bent)
    for share, wide, limit in ((1.1, free, True), (1.1, looser, False), (1.3, looser, True)):
        gain = share * P.ep_converter.gain
        after = Fit((wide,), np.array([wide.variable(gain)]), put(P, 'ep_converter.gain', gain),
                    Initial(0.0), 0.0, np.zeros(1), np.ones((1, 1)))
        problem = SimpleNamespace(freedoms=(wide,))
        draws = after.z + 0.5 * wide.sigma * np.random.default_rng(1).standard_normal((400, 1))
        (found,) = _refitted(SimpleNamespace(freedoms=(free,), declared=P),
                             P, FinalFit(problem, after, draws))
        assert found.at_limit is limit
        assert found.spread == pytest.approx(wide.spread)
        if limit:  # its value is no measurement
            assert np.isnan([found.low, found.high, found.width]).all()
        else:
            assert found.width == pytest.approx(0.5, rel=0.1)
            assert found.high - found.low == pytest.approx(0.5 * 2.0 * 1.96 * wide.spread, rel=0.1)


def test_a_flow_bench_finds_a_gain_far_from_the_declared_one():
    experiment = flow_bench(7e-6, 0.37)
    assert experiment.is_flow_bench
    free = tuple(f for f in declared_freedom(DECLARED, experiment)
                 if f.knob.parameter.startswith('booster.'))
    problem = with_effect(
        Problem(experiment, np.ones(54, dtype=bool), DECLARED, free), EFFECTS['booster_dead_band'])
    starts = [problem.start()]
    starts += [np.where(np.arange(len(starts[0])) == j, 1.0, 0.0) for j in range(2)]
    found = fit(problem, starts, 60)
    assert found.parameters.booster.opening_gain == pytest.approx(7e-6, rel=0.02)
    assert found.parameters.booster.intake_preload == pytest.approx(0.37, rel=0.02)


def test_a_declared_parameter_that_ends_at_its_limit_is_pointed_out():
    for factor, preload in ((2.0, 0.37), (0.5 * BENCH_RANGE, 0.0), (2.0 * BENCH_RANGE, 0.0)):
        experiment = flow_bench(factor * DECLARED.booster.opening_gain, preload)
        found = diagnose(experiment, DECLARED, names=('booster_dead_band',), places=frozenset())
        gain, area = (next(one for one in found.refitted if one.name == f'booster.{name}')
                      for name in ('opening_gain', 'max_area'))
        assert gain.at_limit is (factor > BENCH_RANGE)
        expected = min(factor, BENCH_RANGE) * gain.given
        assert gain.after == pytest.approx(expected, rel=0.02)
        said = [note for note in notes(found) if note.startswith('booster.opening_gain went from')]
        assert len(said) == gain.at_limit
        assert not area.at_limit
        assert not any('max_area' in note for note in notes(found))
