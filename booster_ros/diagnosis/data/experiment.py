# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An experiment: what drives the model, what is compared, and how noisy that is."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from booster_ros.signals.noise_autocorrelation import Noise
from booster_ros.model.memory import CENTRED, Departure
from booster_ros.model.simulation import Simulation, simulate
from booster_ros.model.stream import DEFAULT_TOLERANCE
from booster_ros.model.stream import LONGEST_INTERVAL as DEFAULT_LONGEST_INTERVAL
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

LONGEST_INTERVAL = 0.1
"""Intervals between rows are divided no further than this, s, unless measured drives run between
them: what happens there is smooth."""

PARTS_OF_A_DRIVE = 50
"""Parts into which a measured drive is cut between two rows, each within both longest intervals."""

THINNED_TOLERANCE = 3.0
"""Factor on the solver's tolerance where rows are thinned: an error of 1 Pa and 0.03 um, far below
any noise, at two thirds of the time."""

FEWEST = 12
"""Number of values, of rows to compare or of draws, below which nothing is told by them."""

AVERAGED = 25
"""Number of rows, or samples, whose mean shows what noise hides: it has a fifth of the noise."""

ARRIVED = 0.05
"""Share of the time that a row of a sweep is dwelt on, after which its drives have arrived."""

COMMANDS = ('control_current', 'set_point')
"""The columns that command a valve: what was asked for, not what was measured."""

SLOW = 0.3
"""Distance of rows, s, in one or two of which a valve behind a controller has come to rest: what
holds or slows it shows in how the loop lags alone."""

OUTPUT_OF = {name: f'measured_{name}' for name in ('chamber_pressure', 'valve_position')}
"""The model's output that a channel of a record is compared with, where it has another name."""

UNITS = {'set_point': 'm', 'back_pressure': 'Pa', 'supply_pressure': 'Pa', 'mass_flow': 'kg/s',
         'chamber_pressure': 'Pa', 'valve_position': 'm', 'pressure_drop': 'Pa'}


@dataclass(frozen=True)
class Initial:
    """Where the model starts; fits turn its departures, the back pressure's far if `unsettled`."""

    chamber_pressure: float
    departure: Departure = CENTRED
    valve_position: float | None = None
    unsettled: bool = False


class Chance(NamedTuple):
    """
    What of a channel's noise is no sensor's, but what the same valve would do otherwise next time.

    That is its `share` of the variance; it carries over, by 1/e after so many `seconds`.
    """

    share: float = 0.0
    seconds: float = 1.0


NO_CHANCE = Chance()


@dataclass(frozen=True)
class DriveNoise:
    """
    Noise of a measured drive: its level (unit of the drive), and rows from sample to sample.

    `correlation` is the AR(1) coefficient from sample to sample.
    """

    level: float
    every: int = 1
    correlation: float = 0.0

    def draw(self, rows: int, rng: np.random.Generator) -> Array:
        """Return a draw, shape (rows,): a straight line from each sample to the next."""
        sampled = np.arange(0, rows + self.every, self.every)
        noise = Noise(self.level, self.correlation).added_to(np.zeros(len(sampled)), rng)
        return np.interp(np.arange(rows), sampled, noise)


@dataclass(frozen=True)
class Experiment:
    """
    A record made ready: arrays of shape (n,), SI units.

    `current` commands the valve from each row to the next: it stands or, where there are `ends`,
    runs straight to its value in these. It is what `command` names: a control current, A, for the
    E/P converter, or a set point, m, for the position controller, which is off otherwise. `pinned`
    channels drive what is downstream of them instead of the model's own states; `measured` channels
    are compared, NaN where a row does not count. `noise` is the standard deviation of each one's
    noise, `drive_noise` that of the pinned ones, `chance` what of it the valve leaves to chance. A
    `quasi_static` experiment is a sweep, whose time counts rows; that of any other counts from
    `begins`, s in the record's clock. `notes` say what was left out and assumed; `tolerance`
    multiplies that of the solver. A controller samples every `least_period` s at the shortest.
    """

    time: Array
    current: Array
    measured: dict[str, Array]
    noise: dict[str, float]
    pinned: dict[str, Array]
    initial: Initial
    drive_noise: Mapping[str, DriveNoise] = field(default_factory=dict)
    quasi_static: bool = False
    begins: float = 0.0
    ends: Array | None = None
    notes: tuple[str, ...] = ()
    tolerance: float = DEFAULT_TOLERANCE
    command: str = 'control_current'
    least_period: float = 0.0
    chance: Mapping[str, Chance] = field(default_factory=dict)

    @property
    def channels(self) -> tuple[str, ...]:
        """The compared channels."""
        return tuple(self.measured)

    @property
    def drives(self) -> tuple[str, ...]:
        """The channels that drive the model; none where the chamber is isolated."""
        commanded = (self.command,) if np.any(self.current) else ()
        return (*commanded, *self.pinned)

    @property
    def pinned_within(self) -> frozenset[str]:
        """The pinned channels of the positioner: all but what the process does to the stem."""
        return frozenset(self.pinned) - {'pressure_drop'}

    @property
    def smoothed(self) -> bool:
        """Whether the measured stem drives the model, smoothed over rows."""
        return 'stem_velocity' in self.pinned

    @property
    def in_loop(self) -> bool:
        """Whether a set point drives the model by way of the position controller."""
        return self.command == 'set_point'

    @cached_property
    def is_slow(self) -> bool:
        """Whether rows are so far apart that the loop hides what lies below the controller."""
        return (self.in_loop and 'chamber_pressure' not in self.measured
                and float(np.median(np.diff(self.time))) >= SLOW)

    @property
    def is_flow_bench(self) -> bool:
        """Whether a bench sets the pressures around the booster and reads its flow."""
        return 'mass_flow' in self.measured and 'chamber_pressure' in self.pinned

    def shaken(self, noise: Mapping[str, DriveNoise], rng: np.random.Generator) -> 'Experiment':
        """Return this experiment with draws of this noise added to its measured drives."""
        shaken = {name: self.pinned[name] + one.draw(len(self.time), rng)
                  for name, one in noise.items()}
        return replace(self, pinned=self.pinned | shaken)

    def simulate(self, parameters: PositionerParameters, initial: Initial | None = None
                 ) -> Simulation:
        """Run the model over this experiment."""
        start = initial or self.initial
        state: dict[str, float] = {}
        if 'chamber_pressure' not in self.pinned:
            state['chamber_pressure'] = start.chamber_pressure
        if start.valve_position is not None and 'valve_position' not in self.pinned:
            state['valve_position'] = start.valve_position
        c = parameters.position_controller
        c = c._replace(enabled=self.in_loop, period=max(c.period, self.least_period))
        time, current, pinned, at = self._course()
        run = simulate(
            parameters._replace(position_controller=c), time, current, state, pinned,
            self.tolerance, departure=start.departure, longest_interval=self._longest_interval())
        return Simulation({name: values[at] for name, values in run.columns.items()},
                          run.final_state)

    def _longest_interval(self) -> float:
        """Return the length, s, beyond which intervals between rows are divided."""
        if not self.pinned_within or self.smoothed:
            return LONGEST_INTERVAL
        apart = float(np.median(np.diff(self.time)))
        return min(max(apart / PARTS_OF_A_DRIVE, DEFAULT_LONGEST_INTERVAL), LONGEST_INTERVAL)

    def _course(self) -> tuple[Array, Array, dict[str, Array], Array | slice]:
        """Return time, standing current and measured drives to simulate, and where rows lie."""
        if self.quasi_static and self.pinned and 'chamber_pressure' not in self.pinned:
            return self._dwelt_on()
        if self.ends is None:
            return self.time, self.current, self.pinned, slice(None)
        steps = np.diff(self.time)
        parts = max(1, int(np.ceil(float(np.median(steps)) / LONGEST_INTERVAL)))
        share = (np.arange(parts) + 0.5) / parts  # the middle of each part counts
        way = self.ends - self.current
        current = (self.current[:-1, None] + np.outer(way[:-1], share)).ravel()
        time = (self.time[:-1, None] + np.outer(steps, np.arange(parts) / parts)).ravel()
        time, current = np.append(time, self.time[-1]), np.append(current, self.current[-1])
        return (time, current, {name: np.interp(time, self.time, values)
                                for name, values in self.pinned.items()},
                np.arange(len(self.time)) * parts)

    def _dwelt_on(self) -> tuple[Array, Array, dict[str, Array], Array]:
        """Return the course of a sweep whose drives come soon and stand until each row is read."""
        arrived = self.time[:-1] + ARRIVED * np.diff(self.time)
        time = np.append(np.column_stack([self.time[:-1], arrived]).ravel(), self.time[-1])
        pinned = {name: np.append(values[:1], np.repeat(values[1:], 2))
                  for name, values in self.pinned.items()}
        return time, np.append(np.repeat(self.current[:-1], 2), self.current[-1]), pinned, (
            2 * np.arange(len(self.time)))

    def predict(self, parameters: PositionerParameters, initial: Initial | None = None
                ) -> dict[str, Array]:
        """Return what the model says each compared channel reads."""
        run = self.simulate(parameters, initial)
        return {name: run[OUTPUT_OF.get(name, name)] for name in self.measured}

    def thinned(self, factor: int) -> tuple['Experiment', Array]:
        """
        Return this experiment with fewer rows, and which rows those are.

        Rows at which a drive jumps are kept, and one of every `factor` between them. The current
        between two kept rows is the mean of what it was, a measured drive at a kept row that of the
        rows around it: noise of single rows would be slower, and reach the chamber.
        """
        size = len(self.time)
        keep = np.zeros(size, dtype=bool)
        keep[[0, -1]] = True
        known = np.isfinite(list(self.measured.values()))
        for rows in (*known, ~known.any(axis=0)):  # each channel may have values in other rows
            keep[np.flatnonzero(rows)[::factor]] = True
        # where a drive runs straight from row to row, the row before a jump counts too
        standing, running = (0, 1, 2), (-1, 0, 1, 2)
        around = [np.add.outer(_jumps(self.current), standing if self.ends is None else running)]
        around += [np.add.outer(_jumps(values), running)
                   for name, values in self.pinned.items() if 'pressure' in name]
        for rows in around:
            keep[np.minimum(rows, size - 1)] = True
        kept = np.flatnonzero(keep)
        thin = replace(
            self, time=self.time[kept],
            current=self._mean_current(kept) if self.ends is None else self.current[kept],
            ends=None if self.ends is None else self.ends[np.append(kept[1:], size) - 1],
            measured={name: values[kept] for name, values in self.measured.items()},
            pinned={name: _means_around(values, kept) for name, values in self.pinned.items()},
            tolerance=THINNED_TOLERANCE)
        return thin, kept

    def until(self, time: float) -> 'Experiment':
        """Return this experiment's rows up to this time, s, two at the least."""
        rows = slice(max(int(np.searchsorted(self.time, time, side='right')), 2))
        return replace(
            self, time=self.time[rows], current=self.current[rows],
            ends=None if self.ends is None else self.ends[rows],
            measured={name: values[rows] for name, values in self.measured.items()},
            pinned={name: values[rows] for name, values in self.pinned.items()})

    def _mean_current(self, kept: Array) -> Array:
        """Return the mean of the standing current from each kept row to the next."""
        charge = np.concatenate(([0.0], np.cumsum(self.current[:-1] * np.diff(self.time))))
        mean = np.diff(charge[kept]) / np.diff(self.time[kept])
        return np.concatenate((mean, self.current[-1:]))


def _means_around(values: Array, kept: Array) -> Array:
    """Return the mean of the rows around each kept one, halfway to the nearer kept neighbour."""
    apart = np.diff(kept, prepend=kept[0], append=kept[-1])
    reach = np.minimum(apart[:-1], apart[1:]) // 2
    total = np.concatenate(([0.0], np.cumsum(values)))
    return (total[kept + reach + 1] - total[kept - reach]) / (2 * reach + 1)


def _jumps(drive: Array) -> Array:
    """Return the rows that a drive has reached by a step far larger than usual."""
    step = np.abs(np.diff(drive))
    far = max(20.0 * float(np.median(step)), 1e-3 * float(np.ptp(drive)))
    return np.flatnonzero(step > far) + 1


def rmse(measured: Array, predicted: Array, rows: Array) -> float:
    """
    Return the root mean square difference over the marked rows, NaN where none has a value.

    Rows without a measured value are left out; a prediction that was lost on the way is NaN.
    """
    rows = rows & np.isfinite(measured)
    return float(np.sqrt(np.mean((measured - predicted)[rows]**2))) if rows.any() else float('nan')
