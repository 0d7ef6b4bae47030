# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The hidden plant itself: it solves the declared equations, and what it adds is what it says."""

import ast
import json
import math
from pathlib import Path

import hidden_plant
from hidden_plant import cases
from hidden_plant.__main__ import main
from hidden_plant.campaigns import unseen
from hidden_plant.currents import HIGHEST, KINDS, LOWEST
from hidden_plant.declared import BENCH_SET, drawn_valve
from hidden_plant.effects import CATALOGUED, EFFECTS, NAMELESS, UNCATALOGUED, put_in
from hidden_plant.plant import COLUMNS, SAMPLE_TIME, Valve, run
from hidden_plant.sensors import POSITION_NOISE, PRESSURE_NOISE, Sensors, sensed
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from booster_ros.model import catalogue

STEPS = [(0.38e-3, 6.0), (0.455e-3, 7.0), (0.425e-3, 5.0), (0.37e-3, 6.0), (0.445e-3, 6.0)]


def played(steps: list[tuple[float, float]]) -> np.ndarray:
    """Return the currents of steps to levels (A) that are held for so long (s)."""
    return np.concatenate([np.full(round(hold / SAMPLE_TIME), level) for level, hold in steps])


CURRENT = played(STEPS)
SHUT_TWICE = played([(0.38e-3, 1.0), (0.46e-3, 3.5), (0.36e-3, 4.0), (0.455e-3, 3.5)])
CLOCK = 20.0
"""What the clock says (s) where the stem is played about: by then what comes late has begun."""


def column(rows: np.ndarray, name: str) -> np.ndarray:
    return rows[:, COLUMNS.index(name)]


def with_effect(key: str, size: str = 'medium') -> Valve:
    effect = EFFECTS[key]
    return put_in(effect, effect.size(size), Valve(), Sensors())[0]


def declared_rates(time: float, state: np.ndarray, current: float) -> list[float]:
    """
    Return the rates of (back pressure, chamber pressure, position, velocity) as declared.

    Written once more, in gauge pressures; only the stiffness of the stops is the plant's own.
    """
    back, pressure, x, v = state
    force = 13.52e-6 * back - 3.14e-6 * pressure - 400e3 * (9.28e-6 - 3.14e-6)
    area = min(2.75e-6 * abs(force), 1.45e-6)
    absolute = pressure + 101325.0
    if force > 0.0:
        flow, upstream, ratio = area, 501325.0, absolute / 501325.0
    else:
        flow, upstream, ratio = -area, absolute, 101325.0 / absolute
    clipped = min(max((ratio - 0.5283) / (1.0 - 0.5283), 0.0), 0.999999)
    flow *= 0.0404184 * upstream / math.sqrt(293.15) * math.sqrt(1.0 - clipped**2)
    sprung = 0.0796 * 150e3 * (1.0 + x / 0.016)
    stop = 5e8 * max(-x, 0.0) - 5e8 * max(x - 0.016, 0.0)
    if stop:
        stop -= 4e4 * v
    return [
        (5.40340406719717e8 * current - back) / 0.034,
        (287.05 * 293.15 * flow - absolute * 0.0796 * v) / (0.185e-3 + 0.0796 * x),
        v,
        (0.0796 * pressure - sprung - 3000.0 * v + stop) / 4.0,
    ]


def test_solves_the_declared_equations():
    rows = run(Valve(), CURRENT, 0.0)
    state = rows[0, [COLUMNS.index(n) for n in ('back_pressure', 'chamber_pressure')]]
    state = np.array([*state, rows[0, COLUMNS.index('valve_position')], 0.0])
    start, reference = 0.0, []
    for current, hold in STEPS:
        time = np.arange(round(hold / SAMPLE_TIME) + 1) * SAMPLE_TIME + start
        solution = solve_ivp(
            declared_rates,
            (time[0], time[-1]),
            state,
            method='LSODA',
            t_eval=time,
            args=(current,),
            rtol=1e-7,
            atol=[1.0, 1.0, 1e-8, 1e-6],
        )
        reference.append(solution.y[:, :-1])
        state, start = solution.y[:, -1], time[-1]
    _, pressure, position, _ = np.concatenate(reference, axis=1)
    assert np.sqrt(np.mean((column(rows, 'chamber_pressure') - pressure) ** 2)) < 20.0
    assert np.sqrt(np.mean((column(rows, 'valve_position') - position) ** 2)) < 1e-6
    assert np.ptp(position) > 8e-3  # the comparison has moved the stem, and closed the valve
    assert position.min() < 0.0


@pytest.mark.parametrize(
    'keys', [(), ('tubing_restriction', 'chamber_leak'), ('heat_transfer', 'supply_seat_leak')]
)
def test_conserves_mass(keys):
    valve, sensors = Valve(), Sensors()
    for key in keys:
        valve, sensors = put_in(EFFECTS[key], EFFECTS[key].size('large'), valve, sensors)
    rows = run(valve, CURRENT, 0.0)
    supplied, released = column(rows, 'supplied_mass'), column(rows, 'released_mass')
    stored = column(rows, 'stored_mass')
    assert supplied[-1] > 1e-3
    np.testing.assert_allclose(stored - stored[0], supplied - released, atol=1e-9 * supplied[-1])


def test_friction_holds_the_stem_at_exactly_zero_velocity():
    rows = run(with_effect('stem_friction', 'large'), CURRENT, 0.0)
    position, pressure = column(rows, 'valve_position'), column(rows, 'chamber_pressure')
    stuck = column(rows, 'stem_velocity') == 0.0
    held = stuck[1:] & stuck[:-1] & (position[1:] == position[:-1])
    # Held while the force changes by much of the break-away force, and away from the seat.
    inside = held & (position[1:] > 1e-4)
    assert inside.sum() > 50
    assert 0.0796 * np.ptp(pressure[1:][inside]) > 350.0
    frictionless = run(Valve(), CURRENT, 0.0)
    assert np.count_nonzero(column(frictionless, 'stem_velocity')[1:]) == CURRENT.size - 1


def test_stick_slip_jumps_further_than_coulomb_friction():
    ramp = np.concatenate([np.full(300, 0.40e-3), np.linspace(0.40e-3, 0.44e-3, 3000)])

    def largest_jump(key: str) -> float:
        rows = run(with_effect(key, 'large'), ramp, 0.0)
        return float(np.abs(np.diff(column(rows, 'valve_position'))).max())

    assert largest_jump('stem_friction_stick_slip') > 3.0 * largest_jump('stem_friction_coulomb')


def test_a_packing_that_yields_gives_way_like_a_spring_before_it_slides():
    settle, away = np.full(400, 0.43e-3), np.full(300, 0.4305e-3)
    there_and_back = np.concatenate([settle, away, settle])

    def way(key: str) -> tuple[float, float, float]:
        """Return the change of pressure (Pa), how far the stem goes and comes back (m)."""
        rows = run(with_effect(key, 'large'), there_and_back, 0.0)
        position, pressure = column(rows, 'valve_position'), column(rows, 'chamber_pressure')
        return (pressure[690] - pressure[390], position[690] - position[390],
                position[690] - position[1090])

    pressure, there, back = way('stem_friction_yielding')
    force = 0.0796 * pressure
    assert 50.0 < force < 350.0  # that does not make it slide
    assert there == pytest.approx(force / (3e7 + 0.0796 * 150e3 / 0.016), rel=0.3)
    assert back == pytest.approx(there, rel=0.3)
    assert way('stem_friction')[1:] == (0.0, 0.0)


def test_air_enters_an_insulated_chamber_as_warm_as_the_supply():
    valve = with_effect('heat_transfer')
    valve = valve._replace(chamber=valve.chamber._replace(wall_resistance=1e9))
    filling = np.concatenate([np.full(100, 0.37e-3), np.full(300, 0.40e-3)])  # the stem stays shut
    rows = run(valve, filling, 0.0)
    mass, temperature = column(rows, 'stored_mass'), column(rows, 'gas_temperature')
    energy = 717.6 * mass * temperature
    assert temperature[-1] - temperature[0] > 10.0
    # first law of an open system: what the air brings is c_p times the temperature it comes with
    assert energy[-1] - energy[0] == pytest.approx(
        1004.7 * 293.15 * (mass[-1] - mass[0]), rel=0.01)


def test_expanding_gas_cools_and_returns_to_the_wall_temperature():
    current = np.concatenate([CURRENT[:100], np.full(500, 0.47e-3), np.full(3000, 0.44e-3)])
    temperature = column(run(with_effect('heat_transfer'), current, 0.0), 'gas_temperature')
    assert np.ptp(temperature) > 2.0
    assert temperature[-1] == pytest.approx(293.15, abs=0.2)


def test_air_lost_at_the_exhaust_seat_and_from_the_chamber_is_the_same_without_a_line():
    seat = with_effect('exhaust_seat_leak')
    chamber = Valve()._replace(chamber=Valve().chamber._replace(leak=seat.booster.exhaust_leak))
    np.testing.assert_allclose(run(seat, CURRENT, 0.0), run(chamber, CURRENT, 0.0), rtol=1e-9)


@pytest.fixture(scope='module')
def clean() -> tuple[np.ndarray, np.ndarray]:
    """Return pressure and position of the declared valve, without noise."""
    return sensed(Sensors(), run(Valve(), SHUT_TWICE, CLOCK))


@pytest.mark.parametrize('key', EFFECTS)
def test_effect_shows_in_the_record(key, clean):
    effect = EFFECTS[key]
    valve, sensors = put_in(effect, effect.size('large'), Valve(), Sensors())
    shown = sensed(sensors, run(valve, SHUT_TWICE, CLOCK))
    pressure, position = (np.sqrt(np.mean((a - b) ** 2)) for a, b in zip(shown, clean, strict=True))
    assert max(pressure / PRESSURE_NOISE, position / POSITION_NOISE) > 2.0
    assert (pressure == 0.0) == (effect.location == 'sensor' and 'position' in key)


@pytest.mark.parametrize('key', EFFECTS)
def test_effect_of_size_zero_is_no_effect(key):
    effect = EFFECTS[key]
    valve, sensors = put_in(effect, 0.0, Valve(), Sensors())
    for path in effect.fixed:  # settings without influence while the effect itself is absent
        part, name = path.split('.')
        neutral = getattr(getattr(Valve(), part), name)
        valve = valve._replace(**{part: getattr(valve, part)._replace(**{name: neutral})})
    assert (valve, sensors) == (Valve(), Sensors())
    assert effect.sizes == tuple(sorted(effect.sizes))


NOT_OFFERED = {'travel_limit', 'spring_rate_change', 'stem_damping', 'ep_gain_loss', 'slew_limit',
               'positioner_dead_zone', 'feedback_backlash', 'positioner_tuning', 'process_force',
               'proportional_firmware', 'integrating_firmware', 'pulsing_firmware'}
"""Effects that other rigs have, or a positioner, and that this plant does not play alone."""


def test_offers_every_other_effect_of_the_catalogue_under_its_name_and_location():
    offered = {(effect.names[0], effect.location) for effect in CATALOGUED.values()}
    assert offered == {(effect.name, effect.location) for effect in catalogue.EFFECTS.values()
                       if effect.name not in NOT_OFFERED}


def test_effects_outside_the_catalogue_are_unknown():
    for effect in NAMELESS.values():
        assert effect.names[0] == 'unknown'
        assert set(effect.names[1:]) <= set(catalogue.EFFECTS)


@pytest.mark.parametrize('kind', KINDS)
def test_current_stays_where_the_valve_moves(kind):
    def current(seed: int) -> np.ndarray:
        return KINDS[kind](np.random.default_rng(seed), 150.0)

    assert current(1).size == 15000
    assert LOWEST <= current(1).min() < current(1).max() <= HIGHEST
    assert np.ptp(current(1)) > 0.02e-3
    assert np.array_equal(current(1), current(1))
    assert not np.array_equal(current(1), current(2))


@pytest.mark.parametrize('spread', ['samples', 'wide'])
def test_drawn_valves_are_near_their_name_plate(spread):
    gains, bench_sets = [], []
    for seed in range(200):
        valve = drawn_valve(np.random.default_rng(seed), spread)
        gains.append(valve.converter.gain / Valve().converter.gain - 1.0)
        bench_sets.append(valve.stem.preload / valve.chamber.area / BENCH_SET[0] - 1.0)
    assert 0.003 < np.std(gains) < 0.01
    assert np.max(np.abs(bench_sets)) < 0.005


def test_unseen_set_has_the_promised_mixture(monkeypatch):
    monkeypatch.setattr(hidden_plant.campaigns, 'visibility', lambda case: (math.inf, math.inf))
    drawn = unseen(3, 'samples')
    counts = [len(case.effects) for case in drawn]
    assert (len(drawn), counts.count(0), counts.count(2)) == (31, 5, 5)
    other = [
        case for case in drawn if len(case.effects) == 1 and case.effects[0][0] in UNCATALOGUED
    ]
    assert len(other) == 6
    assert drawn == unseen(3, 'samples')
    assert drawn != unseen(4, 'samples')


def test_program_writes_the_same_folder_for_the_same_seed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cases, 'FIT_SECONDS', 10.0)
    monkeypatch.setattr(cases, 'VALIDATION_SECONDS', 5.0)
    monkeypatch.setattr(cases, 'WARM_UP_SECONDS', 2.0)
    arguments = ['--cases', 'none', 'chamber_leak:large+stem_friction:90', '--seed', '7', '--out']
    folders = [tmp_path / 'one', tmp_path / 'two']
    for folder in folders:
        assert main([*arguments, str(folder)]) == 0
    assert '2/2' in capsys.readouterr().out
    names = sorted(path.name for path in folders[0].iterdir())
    assert len(names) == 7
    for name in names:
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()

    key = json.loads((folders[0] / 'key.json').read_text())
    pair = key['chamber_leak_large+stem_friction_90']
    assert pair['names'] == ['chamber_leak+stem_friction']
    assert pair['location'] == 'chamber+stem'
    assert pair['effect']['stem.coulomb'] == 90.0
    assert key['none']['names'] == ['none']
    record = np.genfromtxt(folders[0] / 'none_fit.csv', delimiter=',', names=True)
    assert record.dtype.names == (
        'time', 'control_current', 'chamber_pressure', 'valve_position',
    )  # fmt: skip
    assert record.size == 1000
    steps = record['chamber_pressure'] / 25.0
    assert np.array_equal(steps, np.round(steps))


@pytest.mark.parametrize('wrong', ['chamber_lek', 'chamber_leak:huge', 'none+chamber_leak'])
def test_program_refuses_what_it_does_not_know(tmp_path, capsys, wrong):
    assert main(['--cases', wrong, '--out', str(tmp_path / 'out')]) == 2
    assert capsys.readouterr().err.count('\n') == 1
    assert not (tmp_path / 'out').exists()


def test_shares_nothing_with_the_model():
    for path in Path(hidden_plant.__file__).parent.glob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                modules = [node.module]
            assert not any(module.split('.')[0] == 'booster_ros' for module in modules), path
