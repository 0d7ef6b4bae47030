# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record may be instead of what it says: a table of suppositions, judged by one rule.

| supposed | the record under that | asked where |
|---|---|---|
| time is in another unit | its time in that unit | rows are not as far apart as is usual |
| pressures are in mbar | a hundred times as much | they are far below the supply |
| pressures are absolute | an atmosphere less | they are never below the atmosphere |
| the supply is another one's | the supply as declared | the chamber rises above the measured one |
| the current is reversed | a current less the recorded one | pressure falls as it rises |
| the position is reversed | its negative | there is a position |

Fitted all the same, such a record comes out as an effect, as absolute pressure does as a process
that pushes on the plug. A record is what is supposed where the declared model then misses less than
EXPLAINED of what it misses of the record as it is (`is_otherwise`).
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
import itertools

import numpy as np
from scipy.constants import day, hour, micro, milli, minute, nano
from scipy.optimize import brute

from booster_ros.diagnosis.data.experiment import Array, Experiment, rmse
from booster_ros.diagnosis.prepare.plausibility import LITTLE, driven, known
from booster_ros.diagnosis.prepare.rows import DWELL_FILLED, check_length
from booster_ros.model.gas import ATMOSPHERE
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError
from booster_ros.signals.rank_correlation import rank_correlation

Moves = tuple[dict[str, Array], dict[str, Array]]
"""What was measured and what the declared model predicts."""

Pair = tuple[Moves, Moves, str]
Supposition = Callable[[Experiment, PositionerParameters], Iterator[Pair]]

EXPLAINED = 0.3
"""Share of the error left where a record is to be taken otherwise: a tenth of its square."""

SMALLEST = 1e-12
"""Least that a channel is taken to move, SI."""

PRESSURES = ('supply_pressure', 'back_pressure', 'chamber_pressure')

SECONDS = {'nanoseconds': nano, 'microseconds': micro, 'milliseconds': milli, 'minutes': minute,
           'hours': hour, 'days': day}
USUAL_STEP = (1e-3, 1.0)
"""Usual distance of rows in seconds: rows of another unit have it in that unit, not in seconds."""

LEVELS = 41
"""Currents to begin with, up to twice what opens the converter: most leave it shut or open."""

FEW = 400
"""Rows that tell how the declared model does where it has settled in each: months in microseconds
are not run through."""


def moves(experiment: Experiment, declared: PositionerParameters) -> Moves:
    """Return what was measured and what the declared model predicts."""
    return experiment.measured, experiment.predict(declared)


def is_otherwise(recorded: Moves, taken: Moves) -> bool:
    """
    Tell whether the declared model misses a record far less if it is taken otherwise.

    Errors are summed over channels, each as a share of how much the channel moves at the most,
    measured or predicted: as a share of what a dead sensor does it would outweigh all else.
    """
    sizes = {name: max(SMALLEST, *(float(np.nanstd(one[name])) for one in (*recorded, *taken)))
             for name, measured in recorded[0].items() if len(known(measured))}
    before, after = (sum(
        rmse(measured[name], predicted[name], np.ones(len(measured[name]), dtype=bool)) / size
        for name, size in sizes.items()) for measured, predicted in (recorded, taken))
    return after < EXPLAINED * before


def check_taken_otherwise(experiment: Experiment, declared: PositionerParameters, source: str
                          ) -> None:
    """Raise RecordError where the declared model moves as measured under a supposition."""
    def check(supposition: Supposition) -> None:
        for recorded, taken, said in supposition(experiment, declared):
            if is_otherwise(recorded, taken):
                raise RecordError(f'{source}, column {said}')

    check(_another_unit_of_time)
    if not experiment.quasi_static:
        check_length(experiment.time, source)  # days may be milliseconds: that is asked before
    for supposition in SUPPOSITIONS:
        check(supposition)


def _another_unit_of_time(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    step = float(np.median(np.diff(experiment.time)))
    if experiment.quasi_static or USUAL_STEP[0] <= step < USUAL_STEP[1]:
        return
    as_given = _closer(experiment) if step > DWELL_FILLED else experiment
    for unit, seconds in SECONDS.items():
        if USUAL_STEP[0] <= seconds * step <= USUAL_STEP[1]:
            taken = replace(experiment, time=seconds * experiment.time)
            yield moves(as_given, declared), moves(taken, declared), (
                f'time: rows {step:.3g} s apart do not suit the declared model, which moves as '
                f'measured if they are {step:.3g} {unit} apart: convert the column to seconds')


def _closer(experiment: Experiment) -> Experiment:
    """Return fewer rows, each of which stands until everything has settled, and no longer."""
    thin, _ = experiment.thinned(max(len(experiment.time) // FEW, 1))
    return replace(thin, time=DWELL_FILLED * np.arange(len(thin.time)))


def _pressures(experiment: Experiment) -> dict[str, Array]:
    """Return the pressures of a record, where it has them."""
    seen = {name: known(values)
            for name, values in {**experiment.measured, **experiment.pinned}.items()}
    return {name: seen[name] for name in PRESSURES if name in seen and len(seen[name])}


def _with_pressures(experiment: Experiment, names: Collection[str], factor: float, less: float
                    ) -> Experiment:
    """Return the experiment with these pressures taken times a factor, less something."""
    measured, pinned = ({name: factor * values - less if name in names else values
                         for name, values in channels.items()}
                        for channels in (experiment.measured, experiment.pinned))
    start = experiment.initial
    if 'chamber_pressure' in names:
        start = replace(start, chamber_pressure=factor * start.chamber_pressure - less)
    return replace(experiment, measured=measured, pinned=pinned, initial=start)


def _in_mbar(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    most = {name: float(np.max(values)) for name, values in _pressures(experiment).items()}
    small = [name for name, reached in most.items()
             if 0.0 < reached < LITTLE * declared.supply.pressure]
    if small:
        in_pascal = _with_pressures(experiment, small, 100.0, 0.0)
        yield moves(experiment, declared), moves(in_pascal, declared), (
            f'{" and ".join(small)}: never exceeds {max(most[name] for name in small):.4g} Pa, and '
            'the declared model moves as measured with a hundred times as much: convert to Pa, '
            'gauge (from mbar: times 100)')


def _absolute(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    high = [name for name, values in _pressures(experiment).items()
            if np.min(values) > (1.0 - LITTLE) * ATMOSPHERE]
    for names in itertools.chain(*(
            itertools.combinations(high, n) for n in range(1, len(high) + 1))):
        gauge = _with_pressures(experiment, names, 1.0, ATMOSPHERE)
        yield moves(experiment, declared), moves(gauge, declared), (
            f'{" and ".join(names)}: the declared model moves as measured with an atmosphere '
            'less, which looks like absolute pressure: subtract that of the atmosphere')


def _another_supply(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    others = dict(experiment.pinned)
    supply = np.max(others.pop('supply_pressure', np.inf))
    chamber = known(experiment.measured.get('chamber_pressure', np.empty(0)))
    if not experiment.quasi_static and np.max(chamber, initial=0.0) > supply:
        fed = replace(experiment, pinned=others)
        yield moves(experiment, declared), moves(fed, declared), (
            f'supply_pressure: never exceeds {supply:.4g} Pa, and the declared model moves as '
            f'measured with {declared.supply.pressure:.4g} Pa: it is not what fed the booster; '
            'correct the column, or leave it out')


def _reversed_current(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    name = next((name for name in PRESSURES if name in experiment.measured), '')
    if not name or experiment.quasi_static or experiment.in_loop:
        return
    measured, current = experiment.measured[name], experiment.current
    rows = np.isfinite(measured)
    both = current[rows], measured[rows]
    if min(map(np.ptp, both)) == 0.0 or rank_correlation(*both) >= 0.0:
        return
    full = declared.supply.pressure / declared.ep_converter.gain

    def counted(way: float) -> tuple[float, Experiment]:
        """Return where the least current suits best, with it that way up, and the record so."""
        def moved(least: float) -> Experiment:
            return replace(experiment, measured={name: measured},
                           current=least + way * current - np.min(way * current))

        least = float(brute(
            lambda at: rmse(measured, moved(float(at[0])).predict(declared)[name], rows),
            ((0.0, 2.0 * full),), Ns=LEVELS)[0])
        return least, moved(least)

    # both from where suits best: a level that is off is no reason to turn what moves
    least, reversed_so = counted(-1.0)
    yield moves(counted(1.0)[1], declared), moves(reversed_so, declared), (
        'control_current: the declared model moves as measured with '
        f'{least + np.max(current):.4g} A less the current: the converter is reverse-acting, or '
        'the wires are swapped; convert the column to the current of a direct-acting one')


def _reversed_position(experiment: Experiment, declared: PositionerParameters) -> Iterator[Pair]:
    position = experiment.measured.get('valve_position', np.empty(0))
    if not len(known(position)):
        return
    predicted = driven(experiment).predict(declared)
    there = predicted['valve_position'][np.isfinite(position)]

    def counted(way: float) -> Moves:
        """Return the record with its position that way up, from wherever suits the model best."""
        off = float(np.mean(there - way * known(position)))
        return {'valve_position': way * position + off}, predicted

    yield counted(1.0), counted(-1.0), (
        'valve_position: falls where the declared model opens: reverse its sign, or, for a valve '
        'that air closes, subtract it from the travel (positions count from the vented stem)')


SUPPOSITIONS: tuple[Supposition, ...] = (
    _in_mbar, _absolute, _another_supply, _reversed_current, _reversed_position)
