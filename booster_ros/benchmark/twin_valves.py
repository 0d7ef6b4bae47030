# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Valves drawn for the twin: parameters, inputs, noise, drift, faults; and their blocks."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from ..model.parameters import from_values
from ..model.stream import Stream
from ..model.system import PositionerParameters
from ..twin.alarm import Alarms, Settings
from ..twin.predictor import TOLERANCE, Predictor
from ..twin.summaries import KINDS, Summary, summary

RATE = 5.0
"""Rows per second."""

BLOCK, LEARNING = 20.0, 2400.0
LASTS, CHANGES = 7200.0, 5400.0
"""Length of a run, and when its valve changes, s."""

DAY = 28800.0
"""Length of a run on which nothing but false alarms are counted, s."""

PROMISES = (1000.0 / 8766.0, 10.0, 100.0)
"""False alarms per 1000 h: one a year, and rates at which some are to be seen."""

PIECE = 2000
LONGEST_INTERVAL = 0.05
"""Into which intervals, s, rows of a valve are divided: with the tolerance of the twin's solver
that makes an error of 1.5 Pa, a hundredth of the noise, at a third of the time."""

NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
"""Of the readings, Pa and m."""

CHANNELS = tuple(NOISE)
NAMES = [(channel, kind) for channel in CHANNELS for kind in KINDS]
CLEAN: dict[str, float] = {}
DECLARED = {'supply.pressure': 400e3, 'ep_converter.gain': 540340406.719717,
            'actuator.viscous_friction': 3000.0}
"""What valves differ in from the model of their twin, as this has it."""


class Run(NamedTuple):
    """Blocks of a valve, and when it changed, s (its end for a clean one)."""

    blocks: list[Summary]
    changed: float


def effects() -> Iterator[tuple[str, dict[str, float]]]:
    """Yield effects and sizes."""
    for newtons in (30.0, 100.0, 300.0):
        yield f'stem friction {newtons:g} N', {'actuator.coulomb_friction': newtons}
    for area in (2e-8, 1e-7):
        yield f'chamber leak {1e6 * area:g} mm²', {'actuator.leak_area': area}
    for shift in (1e3, 3e3):
        yield f'bench set {1e-3 * shift:g} kPa', {'actuator.bench_set_shift': shift}
    for play in (5e-5, 3e-4):
        yield f'feedback backlash {1e6 * play:g} µm', {'sensors.position_backlash': play}


def coloured(random: np.random.Generator, rho: float, size: int) -> np.ndarray:
    """Return first-order noise of variance 1."""
    white = random.standard_normal(size)
    return lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], white)


def near(random: np.random.Generator) -> dict[str, float]:
    """Return the parameters of a valve that is near the model of its twin, but not equal."""
    return {name: value * (1.0 + 0.002 * random.standard_normal())
            for name, value in DECLARED.items()}


def numbers_of(seed: int, fault: Mapping[str, float], lasts: float = LASTS) -> Run:
    """Return the blocks of a drawn valve, run beside a model that is near it but not equal."""
    random = np.random.default_rng(seed)
    time = np.arange(round(lasts * RATE)) / RATE
    current = _input(random, time)
    true = near(random)
    rho = random.choice([0.0, 0.5, 0.9])
    rows = {'time': time, 'control_current': current}
    begin, state = 0, {'chamber_pressure': 2e5}
    seen: dict[str, list[np.ndarray]] = {name: [] for name in CHANNELS}
    change = int(CHANGES * RATE)
    for end, values in ((change, true), (len(time), {**true, **fault})):
        stream = Stream(from_values(values), time[begin], current[begin], state,
                        tolerance=TOLERANCE, longest_interval=LONGEST_INTERVAL)
        told = stream.advance(time[begin:end], current[begin:end])
        for name in CHANNELS:
            seen[name].append(told[f'measured_{name}'])
        state = {name: float(told[name][-1]) for name in CHANNELS}
        begin = end
    drift = np.sin(2.0 * np.pi * (time / 86400.0 + random.random()))
    for name, span in (('chamber_pressure', 400e3), ('valve_position', 0.016)):
        rows[name] = (np.concatenate(seen[name]) + NOISE[name] * coloured(random, rho, len(time))
                      + 0.001 * span * random.random() * drift)
    return Run(_blocks(from_values(DECLARED), rows), CHANGES if fault else lasts)


def _input(random: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Return steps around operating points that shift, with noise of the controller, A."""
    dwell = random.choice([3.0, 8.0, 15.0])
    steps = random.random(int(time[-1] / dwell) + 2)[(time / dwell).astype(int)]
    points = random.random(int(time[-1] / 1200.0) + 2)[(time / 1200.0).astype(int)]
    wide = random.choice([0.01e-3, 0.03e-3, 0.05e-3])
    held = random.standard_normal(len(time)) * random.choice([0.0, 1e-7, 5e-7])
    return 0.405e-3 + 0.02e-3 * points + wide * steps * 0.8 + held


def _blocks(p: PositionerParameters, rows: Mapping[str, np.ndarray]) -> list[Summary]:
    predictor = Predictor(p, frozenset(rows) - {'time'})
    spans = {'chamber_pressure': p.supply.pressure, 'valve_position': p.actuator.travel}
    times: list[np.ndarray] = []
    said: dict[str, list[np.ndarray]] = {name: [] for name in CHANNELS}
    left: dict[str, list[np.ndarray]] = {name: [] for name in CHANNELS}
    for begin in range(0, len(rows['time']), PIECE):
        told = predictor.advance({name: one[begin:begin + PIECE] for name, one in rows.items()})
        times.append(told.time)
        for name in CHANNELS:
            said[name].append(told.said[name])
            left[name].append(told.left[name])
    whole_said, whole_left = ({name: np.concatenate(parts) for name, parts in of.items()}
                              for of in (said, left))
    whole_time = np.concatenate(times)
    size = round(BLOCK * RATE)
    found = []
    for begin in range(0, len(whole_time) - size + 1, size):
        piece = slice(begin, begin + size)
        block = summary(whole_time[piece], {n: v[piece] for n, v in whole_said.items()},
                        {n: v[piece] for n, v in whole_left.items()}, spans)
        if block is not None:
            found.append(block)
    return found


def _alarms(per_thousand: float) -> Alarms:
    return Alarms(Settings(false_alarms=8.766 * per_thousand, block=BLOCK, learning=LEARNING),
                  NAMES)


class Watched(NamedTuple):
    """Of a clean run: hours watched after learning, false alarms by what was promised."""

    hours: float
    alarms: list[int]


def watched(seed: int) -> Watched:
    """Return what came of a clean valve, watched for a working day; see `PROMISES`."""
    blocks = numbers_of(seed, CLEAN, DAY).blocks
    counts = []
    for per_thousand in PROMISES:
        alarms = _alarms(per_thousand)
        counts.append(sum(len(alarms.note(block)) for block in blocks))
    return Watched(sum(block.end > LEARNING for block in blocks) * BLOCK / 3600.0, counts)


def twin_delay(run: Run, per_thousand: float) -> float | None:
    """Return the delay to the first alarm after the change, as `first_seen`."""
    alarms = _alarms(per_thousand)
    return first_seen(np.array([block.end for block in run.blocks if alarms.note(block)]),
                      run.changed)


def first_seen(alarms: np.ndarray, changed: float) -> float | None:
    """Return the delay of the first of these alarms, s: None for none, NaN if it was too early."""
    if not len(alarms):
        return None
    return float(alarms[0] - changed) if alarms[0] > changed else np.nan


def drawn_alarms(hours: float, per_thousand: float) -> tuple[int, float]:
    """Return false alarms and valve-hours over drawn residuals: law, colour and drift by valve."""
    count, each = 0, 200.0
    length = int(each * 3600.0 / BLOCK)
    valves = max(round(hours / each), 1)
    for seed in range(valves):
        random = np.random.default_rng(seed)
        alarms = _alarms(per_thousand)
        rho, degrees = random.choice([0.0, 0.2, 0.4]), random.choice([3.0, 5.0, 30.0])
        drift = random.random() * np.sin(2.0 * np.pi * (
            np.arange(length) * BLOCK / 86400.0 + random.random()))
        columns = []
        for _, kind in NAMES:
            tolerance = alarms.settings.tolerance(kind)
            law = random.standard_t(degrees, length) * 10.0**random.uniform(-1.5, 0.0)
            for k in range(1, length):
                law[k] += rho * law[k - 1]
            columns.append(tolerance * (law + drift))
        cells = [(int(third), 1) for third in
                 random.integers(0, 3, length // 90 + 1).repeat(90)[:length]]
        for k, numbers in enumerate(np.array(columns).T.tolist()):
            count += len(alarms.note(Summary(
                BLOCK * k, BLOCK * (k + 1), dict.fromkeys(CHANNELS, cells[k]),
                dict(zip(NAMES, numbers)))))
    return count, valves * each
