# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which fitted effects stand: sizes told from none and clear of their bounds, and close rivals."""

from dataclasses import replace
from types import SimpleNamespace

from made_diagnosis import DECLARED, record_of, timed_columns
import numpy as np
import pytest

from booster_ros.diagnosis.pipeline import _refitted, diagnose, known_together
from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.problem import START, Fit, Problem
from booster_ros.diagnosis.estimation.parametrisation import (
    BENCH, BENCH_RANGE, declared_freedom, effect_freedom, get, loosened, put)
from booster_ros.diagnosis.estimation.uncertainty import (
    block_bootstrap, interval_of, own_sizes, traded, undetermined)
from booster_ros.diagnosis.last_fit import LastFit
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.result import FoundEffect
from booster_ros.diagnosis.searching.candidate import Candidate, clearly_better
from booster_ros.diagnosis.searching.rematch import rematch
from booster_ros.diagnosis.selection.screening import with_effect
from booster_ros.diagnosis.searching.search import polished
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

P = PositionerParameters()
TIME = np.arange(0.0, 40.0, 0.02)
CURRENT = 4.1e-4 + 4e-5 * np.sign(np.sin(TIME))


def recorded(plant, seed=3, current=CURRENT):
    """Return a noisy record of a plant as an experiment."""
    run = simulate(plant, TIME, current, {'chamber_pressure': 2e5})
    noise = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
    rng = np.random.default_rng(seed)
    measured = {name: run[f'measured_{name}'] + level * rng.standard_normal(len(TIME))
                for name, level in noise.items()}
    return Experiment(TIME, current, measured, noise, {}, Initial(2e5))


def fitted(leak, effect):
    """Return problem, draws and fit of an effect to a noisy record of a plant with a leak."""
    experiment = recorded(put(P, 'actuator.leak_area', leak))
    problem = with_effect(Problem(experiment, np.ones(len(TIME), dtype=bool), P, ()),
                          EFFECTS[effect])
    start = problem.start()
    start[0] = 0.3
    fit = problem.fit(start)
    return problem, block_bootstrap(problem, fit, (TIME // 3.1416).astype(int)), fit


def test_a_leak_that_is_there_stands():
    problem, draws, fit = fitted(3e-8, 'chamber_leak')
    assert fit.parameters.actuator.leak_area == pytest.approx(3e-8, rel=0.05)
    assert undetermined(problem, draws, fit, 'chamber_leak') == ''


def test_a_single_segment_gives_an_interval_as_wide_as_many():
    problem, draws, fit = fitted(3e-8, 'chamber_leak')
    alone = block_bootstrap(problem, fit, np.zeros(len(TIME), dtype=int))
    assert np.std(alone[:, 0]) > 0.3 * np.std(draws[:, 0])


def test_a_leak_that_is_not_there_does_not():
    problem, draws, fit = fitted(0.0, 'chamber_leak')
    assert undetermined(problem, draws, fit, 'chamber_leak') == 'its size is not told from none'


def test_a_drift_stands_though_the_record_is_too_short_to_see_it_end():
    """Its size and its time constant may both be anything, what it has moved so far may not."""
    plant = put(put(P, 'ep_converter.drift', 4000.0), 'ep_converter.drift_time_constant', 1500.0)
    experiment = recorded(plant)
    problem = with_effect(Problem(experiment, np.ones(len(TIME), dtype=bool), P, ()),
                          EFFECTS['ep_drift'])
    fit = problem.fit(problem.start() + np.array([2.0, 0.5, *np.zeros(problem.nuisances)]))
    draws = block_bootstrap(problem, fit, (TIME // 3.1416).astype(int))
    assert undetermined(problem, draws, fit, 'ep_drift') == ''
    ep = fit.parameters.ep_converter
    slope = ep.drift / ep.drift_time_constant
    assert slope == pytest.approx(4000.0 / 1500.0, rel=0.1)
    found = interval_of(problem, draws, fit, 0)
    assert 0.0 < found.low < found.value < found.high
    shape = interval_of(problem, draws, fit, 1)
    assert shape.high > 2.0 * shape.low


def made_fit(effect, z, draws, columns=None):
    """Return a problem with one effect and a fit that stands at z, with these draws."""
    free = tuple(effect_freedom(EFFECTS[effect]))
    experiment = Experiment(TIME, CURRENT, {'chamber_pressure': np.zeros_like(TIME)},
                            {'chamber_pressure': 1.0}, {}, Initial(0.0))
    problem = Problem(experiment, np.ones(len(TIME), dtype=bool), P, free)
    z = np.append(z, np.zeros(problem.nuisances))
    jacobian = np.ones((len(TIME), len(z))) if columns is None else columns
    draws = np.hstack([draws, np.zeros((len(draws), problem.nuisances))])
    return problem, draws, Fit(free, z, P, Initial(0.0), 0.0, jacobian)


RNG = np.random.default_rng(5)


def test_an_effect_at_its_bound_imitates_something_else():
    bound = EFFECTS['dead_time'].knobs[0].high / EFFECTS['dead_time'].knobs[0].typical
    for z, expected in ((bound, 'ep_converter.dead_time runs into its bound'), (0.5 * bound, '')):
        problem, draws, fit = made_fit(
            'dead_time', [z], z + 0.1 * RNG.standard_normal((400, 1)))
        assert undetermined(problem, draws, fit, 'dead_time') == expected


@pytest.mark.parametrize(('time_constant', 'said'), [(6000.0, True), (10.0, False)])
def test_a_size_that_its_shape_can_stand_for_is_said_to_be_known_only_with_it(time_constant, said):
    """Of a drift whose beginning alone was seen: so many Pa a second, and nothing of its end."""
    plant = put(put(P, 'ep_converter.drift', 25.0 * time_constant),
                'ep_converter.drift_time_constant', time_constant)
    problem = with_effect(Problem(recorded(plant), np.ones(len(TIME), dtype=bool), P, ()),
                          EFFECTS['ep_drift'])
    fit = problem.fit(np.r_[1.0, np.zeros(len(problem.start()) - 1)])
    drift = fit.parameters.ep_converter
    assert drift.drift / drift.drift_time_constant == pytest.approx(25.0, rel=0.1)
    found = FoundEffect('ep_drift', 'ep_converter', {}, (), '', {})
    sentences = known_together((found,), LastFit(problem, fit))
    assert len(sentences) == said
    assert all('ep_converter.drift and ep_converter.drift_time_constant' in one
               for one in sentences)


def test_single_slips_do_not_tell_a_drift_at_its_bound_from_its_time_constant():
    """A drift that has hardly begun is known as so many Pa a second, beside a stem that sticks."""
    bound = EFFECTS['ep_drift'].knobs[0].high / EFFECTS['ep_drift'].knobs[0].typical
    z = np.array([bound, 12.0])
    problem, draws, fit = made_fit('ep_drift', z, z + 0.1 * RNG.standard_normal((400, 2)))
    columns = np.zeros((len(TIME), len(fit.z)))
    columns[:, 0], columns[:, 1] = 0.01 * TIME, -0.02 * TIME
    slips = RNG.choice(len(TIME), 20, replace=False)
    columns[slips, 1] += RNG.standard_normal(20)
    free = replace(fit, jacobian=columns)
    sticking = replace(free, parameters=put(P, 'actuator.coulomb_friction', 300.0))
    assert traded(problem, free, 'ep_drift') == []
    assert undetermined(problem, draws, free, 'ep_drift').endswith('runs into its bound')
    assert traded(problem, sticking, 'ep_drift') == ['ep_converter.drift']
    assert undetermined(problem, draws, sticking, 'ep_drift') == ''


def test_two_sizes_of_which_only_the_sum_is_known_stand_together():
    share = 3.0 * RNG.standard_normal((400, 1))
    blur = 0.05 * RNG.standard_normal((400, 2))
    draws = np.hstack([0.5 + share, 0.5 - share]) + blur
    problem, draws, fit = made_fit('booster_dead_band', [0.5, 0.5], draws)
    assert np.quantile(draws[:, 0], 0.1) < 0.0 < np.quantile(draws[:, 0], 0.9)
    assert undetermined(problem, draws, fit, 'booster_dead_band') == ''


def test_they_stand_also_where_the_fit_gave_all_of_it_to_one():
    share = 3.0 * RNG.standard_normal((400, 1))
    draws = np.hstack([1.0 + share, -share]) + 0.05 * RNG.standard_normal((400, 2))
    problem, draws, fit = made_fit('booster_dead_band', [1.0, 1e-6], draws)
    assert np.quantile(draws[:, 0], 0.1) < 0.0
    assert undetermined(problem, draws, fit, 'booster_dead_band') == ''
    nothing = np.hstack([share, -share]) + 0.05 * RNG.standard_normal((400, 2))
    problem, draws, fit = made_fit('booster_dead_band', [1e-6, 0.01], nothing)
    assert undetermined(
        problem, draws, fit, 'booster_dead_band') == 'its size is not told from none'


@pytest.mark.parametrize('segments', [[3], [3, 9], range(14)])
def test_an_effect_that_few_segments_show_is_told_from_none(segments):
    of_row = np.arange(len(TIME)) * 14 // len(TIME)
    problem, _, fit = fitted(3e-8, 'chamber_leak')
    shown = np.tile(np.isin(of_row, segments), len(problem.experiment.channels))
    priors = len(fit.jacobian) - len(shown)
    fit = replace(fit, jacobian=fit.jacobian * np.append(shown, np.ones(priors))[:, None])
    draws = block_bootstrap(problem, fit, of_row)
    assert undetermined(problem, draws, fit, 'chamber_leak') == ''


def twice(fitted, by_segment):
    """Return a model that leaves so much of the fit segments per row, and of each select one."""
    made = candidate('seat_load', fitted * len(TIME))
    rows = replace(made.problem.experiment, measured={'chamber_pressure': np.zeros(len(TIME))})
    return replace(made, problem=replace(made.problem, experiment=rows), samples=400,
                   by_segment=100.0 * np.array(by_segment))


@pytest.mark.parametrize(('fitted', 'by_segment', 'better'), [
    (1.02, [1.1, 1.0, 1.1, 1.0], True),
    (8.0, [1.1, 1.0, 1.1, 1.0], False),  # the fit segments do not show it
    (1.02, [1.1, 1.0, 9.0, 1.0], False),  # nor is it all of it
    (1.02, [6.0, 1.0, 1.1, 1.0], False),  # it does harm elsewhere
])
def test_what_one_select_segment_shows_counts_if_the_fit_segments_show_it_too(
        fitted, by_segment, better):
    without = twice(12.0, [1.0, 1.0, 40.0, 1.0])
    assert clearly_better(twice(fitted, by_segment), without) is better


def test_a_size_that_moves_nothing_is_not_told_from_none():
    still = np.zeros((len(TIME), 1 + len(START)))
    problem, draws, fit = made_fit(
        'dead_time', [1.0], 1.0 + 0.01 * RNG.standard_normal((400, 1)), still)
    assert undetermined(problem, draws, fit, 'dead_time') == 'its size is not told from none'


def test_what_an_effect_shares_with_a_plainer_one_is_not_its_own():
    assert own_sizes('position_dependent_friction') == {
        'actuator.friction_gradient', 'actuator.friction_peak'}
    assert own_sizes('stem_friction') == {'actuator.coulomb_friction', 'actuator.stiction'}


def candidate(effect, score, sizes=1):
    problem, _, fit = made_fit(effect, [1.0] * len(effect_freedom(EFFECTS[effect])),
                               np.zeros((2, len(effect_freedom(EFFECTS[effect])))))
    fit = replace(fit, cost=score)
    return Candidate((effect,), problem, fit, np.array([score]), 0.0, 1000)


@pytest.mark.parametrize(('costs', 'at_its_bound', 'winner'), [
    ((1000.0, 995.0), '', 'chamber_leak'),  # hardly apart: the commoner cause
    ((1000.0, 950.0), '', 'exhaust_seat_leak'),
    ((1000.0, 950.0), 'exhaust_seat_leak', 'chamber_leak'),  # every row shows the fault
    ((950.0, 1000.0), '', 'chamber_leak')])
def test_close_rivals_meet_again_on_every_row(costs, at_its_bound, winner):
    chosen, rival = candidate('chamber_leak', 1010.0), candidate('exhaust_seat_leak', 1020.0)
    far, broken = candidate('dead_time', 5000.0), replace(
        candidate('supply_seat_leak', 1.0), fault='at its bound')
    whole = {'chamber_leak': costs[0], 'exhaust_seat_leak': costs[1]}
    asked = []

    def to_the_end(one):
        asked.append(one.effects[0])
        return replace(one, fit=replace(one.fit, cost=whole[one.effects[0]]))

    search = SimpleNamespace(
        to_the_end=to_the_end, names=(), thinning=1, on=lambda problem, *_: problem,
        problem=lambda: chosen.problem, joint=lambda problem, _: problem,
        judged=lambda one: replace(one, fault='at its bound' * (at_its_bound in one.effects)))
    ranked = rematch(search, chosen, [chosen, rival, far, broken])
    assert asked == ['chamber_leak', 'exhaust_seat_leak']
    assert ranked[0].effects == (winner,)


def bench(gain, preload):
    """Return a flow bench's experiment: flow over back pressure at two supply pressures."""
    back = np.tile(np.linspace(60e3, 125e3, 27), 2)
    columns = {'back_pressure': back, 'supply_pressure': np.repeat([150e3, 200e3], 27),
               'chamber_pressure': np.zeros(54), 'mass_flow': np.linspace(0.0, 1e-3, 54)}
    experiment = prepare(record_of(columns), DECLARED)
    plant = put(put(DECLARED, 'booster.opening_gain', gain), 'booster.intake_preload', preload)
    flow = experiment.predict(plant)['mass_flow']
    return replace(experiment, measured={'mass_flow': flow}, noise={'mass_flow': 1e-6})


def test_a_flow_bench_finds_a_gain_far_from_the_declared_one():
    experiment = bench(7e-6, 0.37)
    assert experiment.is_flow_bench
    free = tuple(f for f in declared_freedom(DECLARED, experiment)
                 if f.knob.parameter.startswith('booster.'))
    problem = with_effect(
        Problem(experiment, np.ones(54, dtype=bool), DECLARED, free), EFFECTS['booster_dead_band'])
    fit = polished(problem, problem.fit(evaluations=60))
    assert fit.parameters.booster.opening_gain == pytest.approx(7e-6, rel=0.02)
    assert fit.parameters.booster.intake_preload == pytest.approx(0.37, rel=0.02)


def test_the_range_of_a_bench_holds_no_place_where_its_parameters_stand_still():
    for name in BENCH:
        free = next(f for f in declared_freedom(DECLARED, bench(7e-6, 0.37))
                    if f.knob.parameter == name)
        given = get(DECLARED, name)
        assert free.value(free.low) == pytest.approx(BENCH_RANGE * given)
        assert free.value(free.high) == pytest.approx(given / BENCH_RANGE)
        assert free.value(free.low + 1e-3) < 0.99 * free.value(free.low)


def test_stops_may_hardly_yield_but_not_be_as_soft_as_a_seat():
    name = 'actuator.stop_stiffness'
    free = next(f for f in declared_freedom(DECLARED, recorded(P)) if f.knob.parameter == name)
    assert free.value(free.low) == pytest.approx(10.0 * get(DECLARED, name))
    assert get(DECLARED, name) / 3.0 < free.value(free.high) < get(DECLARED, name) / 2.0


def test_a_seat_that_yields_is_told_from_stops_that_do():
    stiffness = 2e7
    closing = np.where(TIME < 20.0, CURRENT, 3.8e-4)
    experiment = recorded(put(P, 'actuator.seat_stiffness', stiffness), current=closing)
    problem = Problem(experiment, np.ones(len(TIME), dtype=bool), P,
                      tuple(declared_freedom(P, experiment)))
    joint = with_effect(problem, EFFECTS['seat_load'])
    refit, fit = problem.fit(), joint.fit()
    assert refit.cost > 1.5 * problem.rows_counted()
    assert fit.cost < 1.1 * problem.rows_counted()
    assert fit.parameters.actuator.seat_stiffness == pytest.approx(stiffness, rel=0.1)


def test_a_stem_that_sticks_starts_behind_the_play_of_its_sensor():
    sticking = put(put(P, 'actuator.coulomb_friction', 300.0), 'sensors.position_backlash', 5e-4)
    experiment = replace(recorded(P), initial=Initial(2e5, valve_position=4e-3))
    problem = Problem(experiment, np.ones(len(TIME), dtype=bool), sticking, ())
    z = problem.start()
    z[3] = -1.0  # the sensor's part lies at the lower end of its play
    first = problem.predict(z)['valve_position'][0]
    assert first == pytest.approx(4e-3, abs=1e-7)


def test_warm_air_in_a_shut_chamber_loses_pressure_until_it_is_as_cold_as_its_wall():
    shut = put(put(P, 'booster.opening_gain', 0.0), 'actuator.thermal_resistance', 1.0)
    time = np.arange(0.0, 60.0, 0.1)
    still = np.zeros_like(time)
    given = {'chamber_pressure': 1e5}

    def pressure(parameters, warmth):
        return simulate(parameters, time, still, given,
                        departure=Departure(temperature=warmth))['chamber_pressure']

    warm = pressure(shut, 20.0)
    absolute = 101325.0 + warm
    ambient = shut.supply.temperature
    assert absolute[-1] / absolute[0] == pytest.approx(ambient / (ambient + 20.0), rel=1e-3)
    assert np.ptp(pressure(shut, 0.0)) < 1.0
    assert np.ptp(pressure(put(shut, 'actuator.thermal_resistance', 0.0), 20.0)) < 1.0


def test_a_stem_whose_friction_fades_along_the_travel_keeps_moving_sensibly():
    act = P.actuator._replace(coulomb_friction=18.3, friction_gradient=-25.4,
                              presliding_stiffness=2.76e6, viscous_friction=150.0)
    time = np.arange(0.0, 20.0, 0.08)
    current = np.where(np.sin(time) > 0.0, 4.7e-4, 4.0e-4)
    run = simulate(P._replace(actuator=act), time, current,
                   {'chamber_pressure': 2.76e5, 'valve_position': 0.01347})
    position = run['valve_position']
    assert np.all(np.isfinite(position))
    assert -1e-4 < position.min() < position.max() < P.actuator.travel + 1e-4
    assert np.ptp(position) > 0.002


def test_the_interval_of_a_stiffness_that_may_be_rigid_holds_its_value():
    knob = next(k for k in EFFECTS['stem_friction'].knobs if k.inverse)
    softness = 1.0 / knob.typical  # z is softness in those of the typical stiffness
    z = (1.0 / 3.6e6) / softness
    free = effect_freedom(EFFECTS['stem_friction'])
    index = next(j for j, f in enumerate(free) if f.knob is knob)
    draws = np.zeros((400, len(free)))
    draws[:, index] = z + 2.0 * z * RNG.standard_normal(400)
    where = np.zeros(len(free))
    where[index] = z
    problem, draws, fit = made_fit('stem_friction', where, draws)
    found = interval_of(problem, draws, fit, index)
    assert found.value == pytest.approx(3.6e6)
    assert knob.low <= found.low < 1.5e6
    assert found.open_above
    assert not found.is_none


def test_the_interval_of_a_stiffness_that_was_found_rigid_says_from_where_it_may_be():
    """Not that it lies between rigid, which is 0, and that: what is softer is excluded."""
    free = effect_freedom(EFFECTS['stem_friction'])
    index = next(j for j, f in enumerate(free) if f.knob.inverse)
    draws = np.zeros((400, len(free)))
    draws[:, index] = np.abs(0.1 * RNG.standard_normal(400))
    problem, draws, fit = made_fit('stem_friction', np.zeros(len(free)), draws)
    found = interval_of(problem, draws, fit, index)
    assert found.value == 0.0
    assert found.is_none
    assert found.low == pytest.approx(free[index].knob.typical / 0.2, rel=0.1)
    assert found.holds_none(free[index].knob)


def test_skewed_draws_give_an_interval_that_is_as_long_on_either_side():
    free = effect_freedom(EFFECTS['chamber_leak'])
    draws = np.zeros((400, len(free)))
    draws[:, 0] = 2.0 + RNG.exponential(0.2, 400)
    problem, draws, fit = made_fit('chamber_leak', np.append(2.0, np.zeros(len(free) - 1)), draws)
    found = interval_of(problem, draws, fit, 0)
    assert found.value - found.low == pytest.approx(found.high - found.value)
    assert found.high == pytest.approx(free[0].value(2.0 + 0.2 * np.log(20.0)), rel=0.02)


def test_a_size_that_a_bound_holds_back_may_be_as_large_as_one_that_just_shows():
    """The rows would rather have less than no leak, by more than twice as much as they tell."""
    experiment = recorded(P, seed=5)
    problem = with_effect(Problem(experiment, np.ones(len(TIME), dtype=bool), P, ()),
                          EFFECTS['chamber_leak'])
    fit = problem.fit()
    pull = fit.jacobian[:, 0] @ problem.residuals(fit.z) / np.linalg.norm(fit.jacobian[:, 0])
    assert fit.z[0] < 1e-6
    assert pull > 2.0
    draws = block_bootstrap(problem, fit, (TIME // 3.1416).astype(int))
    assert abs(np.mean(draws[:, 0])) < 0.2 * np.std(draws[:, 0])
    found = interval_of(problem, draws, fit, 0)
    seen_at = problem.freedoms[0].scale / np.linalg.norm(fit.jacobian[:, 0])
    assert 1.2 * seen_at < found.high < 3.0 * seen_at


def test_a_size_that_no_row_shows_goes_back_to_neutral():
    experiment = bench(7e-6, 0.37)
    problem = with_effect(
        Problem(experiment, np.ones(54, dtype=bool), DECLARED, ()), EFFECTS['booster_dead_band'])
    fit = problem.at(np.array([10.0, 4.0]))
    booster = problem.without_unseen(fit).parameters.booster
    assert fit.parameters.booster.exhaust_preload > 0.0  # a bench never exhausts
    assert booster.exhaust_preload == 0.0
    assert booster.intake_preload == fit.parameters.booster.intake_preload > 0.0
    without = problem.without_unseen(fit)
    assert without.cost == problem.cost(without.z)
    preload = [free.knob.parameter for free in fit.freedoms].index('booster.exhaust_preload')
    drawn = block_bootstrap(problem, fit, np.arange(54))
    nothing = interval_of(problem, drawn, fit, preload)
    assert (nothing.low, nothing.high) == (0.0, 1.0)


def test_a_declared_parameter_that_ends_at_its_limit_is_pointed_out():
    for factor, preload in ((2.0, 0.37), (0.5 * BENCH_RANGE, 0.0), (2.0 * BENCH_RANGE, 0.0)):
        experiment = bench(factor * DECLARED.booster.opening_gain, preload)
        found = diagnose(experiment, DECLARED)
        gain, area = (next(one for one in found.refitted if one.name == f'booster.{name}')
                      for name in ('opening_gain', 'max_area'))
        assert gain.at_limit is (factor > BENCH_RANGE)
        expected = min(factor, BENCH_RANGE) * gain.given
        assert gain.after == pytest.approx(expected, rel=0.02)
        said = [note for note in found.notes if note.startswith('booster.opening_gain went from')]
        assert len(said) == gain.at_limit
        assert not area.at_limit
        assert not any('max_area' in note for note in found.notes)


def test_beside_what_loosens_it_a_parameter_has_its_own_limit():
    """A gain 12 % off is at the end of a usual refit, and not of one beside a bent curve."""
    free = next(one for one in declared_freedom(P, prepare(record_of(timed_columns()), P))
                if one.knob.parameter == 'ep_converter.gain')
    bent = EFFECTS['ep_nonlinearity']
    looser = loosened(free, bent)
    for share, wide, limit in ((1.1, free, True), (1.1, looser, False), (1.3, looser, True)):
        gain = share * P.ep_converter.gain
        start = Fit((wide,), np.zeros(1), P, Initial(0.0), 0.0, np.ones((1, 1)))
        after = replace(start, z=np.array([wide.variable(gain)]),
                        parameters=put(P, 'ep_converter.gain', gain))
        problem = SimpleNamespace(freedoms=(wide,))
        draws = after.z + 0.5 * wide.sigma * np.random.default_rng(1).standard_normal((400, 1))
        (found,) = _refitted(start, LastFit(problem, after, draws),
                             SimpleNamespace(freedoms=(free,), declared=P))
        assert found.at_limit is limit
        assert found.spread == pytest.approx(wide.spread)
        if limit:  # its value is no measurement
            assert np.isnan([found.low, found.high, found.width]).all()
        else:
            assert found.width == pytest.approx(0.5, rel=0.1)
            assert found.high - found.low == pytest.approx(0.5 * 2.0 * 1.96 * wide.spread, rel=0.1)
