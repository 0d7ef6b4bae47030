# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What is to be estimated: a vector z of dimensionless variables, and the residuals that it leaves.

The cost of z is, up to a constant, minus twice the logarithm of its posterior density:

    sum over channels ((measured - model(z)) / noise)²  +  sum (z / sigma)²,

where the first sum is over rows or over statistics of windows (`observation`), and the second over
what is known beforehand of declared parameters and of the start. Variables are those of the
parameters, then those of the start.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from booster_ros.diagnosis.data.experiment import NO_CHANCE, Array, Experiment, Initial
from booster_ros.diagnosis.estimation.observation import ROWS, Observation, Steps
from booster_ros.diagnosis.estimation.parametrisation import Free, possible_departures, put
from booster_ros.model.discrepancy import remembers
from booster_ros.model.memory import Departure
from booster_ros.model.parameters import is_consistent
from booster_ros.model.sensors import position_behind, pressure_behind
from booster_ros.model.start import held_by_friction
from booster_ros.model.system import PositionerParameters
from booster_ros.numerics.parallel import side_by_side
from booster_ros.signals.window_statistics import Windows

DIFFERENCE, SMALLEST_DIFFERENCE = 2e-3, 2e-5
"""First step in z of the Jacobian's differences, and the least of later ones, which are those of
the observation (`Steps`)."""

START = np.array([3.0, 4.0, 1.0, 1.0, 2.0, 1.0])
"""Standard deviations of the start around the experiment's: chamber pressure in 100 Pa, back
pressure in 500 Pa, places in the two plays, warmth of the chamber's air in 10 K, what a term
remembers in 0.3 units of `past`."""

UNSETTLED = 50.0
"""Factor on that of the back pressure where a record begins in motion: 100 kPa, half a stroke's."""

START_BOUND = (np.inf, np.inf, 1.0, 1.0, 10.0, 5.0)
"""Bounds of the same variables to either side: a place in a play is -1 to 1 by definition."""

GRID = 2.0**-27
"""Distance between values of z with which the model is run: processors round differently, and where
the stem sticks a difference in the last bit becomes another slip."""

FAR = 1e3
"""Scaled residual where the model cannot run: large, finite, flat, so that a fit turns away."""


@dataclass(frozen=True)
class Problem:
    """An experiment, the rows that count (mask), what of them counts, and what is free."""

    experiment: Experiment
    rows: Array
    base: PositionerParameters
    freedoms: tuple[Free, ...]
    observation: Observation = ROWS

    @property
    def nuisances(self) -> int:
        """Number of variables for the start, behind those of the parameters."""
        return 0 if 'chamber_pressure' in self.experiment.pinned else len(START)

    def parameters(self, z: Array) -> PositionerParameters:
        """Return the parameters at z, to GRID."""
        p = self.base
        for free, variable, nearest in zip(self.freedoms, z, _on_grid(z)):
            low, high = min(variable, free.low), max(variable, free.high)  # no step out of bounds
            value = free.value(min(max(nearest, low), high))
            p = put(p, free.knob.parameter, value, free.element)
        return p

    def initial(self, z: Array, p: PositionerParameters) -> Initial:
        """Return the start at z; a stem that friction holds is held next to where it was seen."""
        start = self.experiment.initial
        if self.nuisances:
            pressure, back, ep_play, position_play, warmth, past = _on_grid(
                z[len(self.freedoms):])
            back = start.departure.back_pressure + 500.0 * back
            start = replace(
                start, departure=Departure(back, ep_play, position_play, 10.0 * warmth, 0.3 * past),
                chamber_pressure=pressure_behind(
                    p.sensors, start.chamber_pressure + 100.0 * pressure))
        if start.valve_position is None:
            return start
        read = position_behind(p.sensors, start.valve_position)
        stem = read - 0.5 * p.sensors.position_backlash * start.departure.position_play
        return replace(start, valve_position=held_by_friction(
            p, float(self.experiment.time[0]), float(self.experiment.current[0]), {
                'chamber_pressure': start.chamber_pressure, 'valve_position': stem,
                'pressure_drop': float(self.experiment.pinned.get('pressure_drop', [0.0])[0])}))

    def predict(self, z: Array, over: Experiment | None = None) -> dict[str, Array] | None:
        """Return the channels at z, over this or another experiment, None where it cannot run."""
        p = self.parameters(z)
        start = self.initial(z, p)
        return (over or self.experiment).predict(p, start) if is_consistent(p) else None

    def residuals(self, z: Array) -> Array:
        """Return the residuals of what is observed, followed by those of what is known before."""
        observed = map(self.observation.of, self.windows, self.scaled(z))
        return np.concatenate([*observed, z[self.known] / self.sigma[self.known]])

    def cost(self, z: Array) -> float:
        """Return the sum of squares of the residuals."""
        return float(np.sum(self.residuals(z)**2))

    @cached_property
    def sigma(self) -> Array:
        """The standard deviation of what is known of each variable, infinite where nothing is."""
        start = START[:self.nuisances].copy()
        start[1:2] *= UNSETTLED if self.experiment.initial.unsettled else 1.0
        return np.append([free.sigma for free in self.freedoms], start)

    @cached_property
    def known(self) -> Array:
        """The variables of which something is known beforehand, as indices."""
        return np.flatnonzero(np.isfinite(self.sigma))

    @cached_property
    def counted(self) -> dict[str, Array]:
        """The rows of each channel that count, as a mask of shape (n,): marked, with a value."""
        return {name: self.rows & np.isfinite(measured)
                for name, measured in self.experiment.measured.items()}

    @cached_property
    def windows(self) -> tuple[Windows, ...]:
        """The counted rows of each channel, in windows."""
        experiment = self.experiment
        return tuple(Windows.of(
            experiment.time[rows], experiment.measured[name][rows] / experiment.noise[name],
            *experiment.chance.get(name, NO_CHANCE)) for name, rows in self.counted.items())

    @cached_property
    def first_rows(self) -> tuple[Array, ...]:
        """For each series of residuals, the row of the experiment that each of them begins with."""
        return tuple(np.flatnonzero(rows)[first]
                     for rows, one in zip(self.counted.values(), self.windows)
                     for first in self.observation.first_rows(one))

    @cached_property
    def observed(self) -> int:
        """Number of observed residuals, over all channels."""
        return sum(map(len, self.first_rows))

    def series(self, observed: Array) -> list[Array]:
        """Return residuals of what is observed, one array a series."""
        return np.split(observed, np.cumsum([len(rows) for rows in self.first_rows])[:-1])

    @cached_property
    def _decisive(self) -> Experiment:
        """The experiment up to the last row that counts: what comes later changes none of them."""
        counting = np.flatnonzero(np.any(list(self.counted.values()), axis=0))
        return self.experiment.until(self.experiment.time[counting[-1] if len(counting) else 0])

    def scaled(self, z: Array) -> list[Array]:
        """Return the scaled residuals of the rows that count, one array a channel."""
        predicted = self.predict(z, self._decisive)
        if predicted is None:
            return [np.full(np.count_nonzero(rows), FAR) for rows in self.counted.values()]
        measured, noise = self.experiment.measured, self.experiment.noise
        return [
            np.nan_to_num(
                (measured[name][rows] - predicted[name][rows[:len(predicted[name])]])
                / noise[name], nan=FAR, posinf=FAR, neginf=-FAR)
            for name, rows in self.counted.items()]

    def jacobian(self, z: Array, here: Array, before: Array | None = None) -> Array:
        """
        Return d(residuals)/dz by one-sided differences, columns side by side.

        `here` are the residuals at z; an earlier Jacobian `before` tells how far to step.
        """
        steps = np.full(len(z), self.first_step) if before is None else self.steps_for(
            np.linalg.norm(before, axis=0), self.observation.steps)
        silent = self._silent(z)
        columns = np.zeros((len(here), len(z)))
        told = [j for j in range(len(z)) if j not in silent]
        columns[:, told] = self.differences(z, here, told, steps)
        for j in silent:  # such a variable moves what is known of it alone
            columns[len(here) + j - len(z), j] = 1.0 / self.sigma[j]
        return columns

    def differences(self, z: Array, here: Array, which: Sequence[int], steps: Array) -> Array:
        """Return the columns of some variables in the Jacobian, by such steps in each variable."""
        low, high = self.bounds()

        def column(j: int) -> Array:
            step = steps[j] if z[j] + steps[j] <= high[j] else -steps[j]
            if z[j] + step < low[j]:  # nor is there room enough on the other side
                step = max(high[j] - z[j], low[j] - z[j], key=abs)
            moved = z.copy()
            moved[j] += step
            return (self.residuals(moved) - here) / step

        return np.reshape(side_by_side(column, which), (len(which), len(here))).T

    def steps_for(self, slopes: Array, steps: Steps) -> Array:
        """Return how far to step for differences, in z, where slopes have these norms."""
        visible, most = steps
        if not self.observation.summary:  # it has to stand out of the solver's own error
            visible *= self.experiment.tolerance**2
        visible = max(visible, self._rough)
        most = self.first_step if self._rough else most
        return _on_grid(np.clip(visible / np.maximum(slopes, 1e-9), SMALLEST_DIFFERENCE, most))

    @property
    def first_step(self) -> float:
        """How far to step for differences, in z, where no slope is known."""
        return 1.0 if self._rough else DIFFERENCE  # beyond several steps of chance

    @cached_property
    def _rough(self) -> float:
        """By how much residuals differ (norm) that differ by chance alone."""
        return float(np.sqrt(2.0 * sum(one.share * len(one.time) for one in self.windows)))

    def _silent(self, z: Array) -> list[int]:
        """Return the variables of the start that cannot matter, such as a place in no play."""
        if not self.nuisances:
            return []
        p = self.parameters(z)
        matter = possible_departures(p) | {'back_pressure'}
        if remembers(p.discrepancy):
            matter.add('past')
        first = len(self.freedoms) + 1  # behind the chamber's pressure
        return [j for j, name in enumerate(Departure._fields, first) if name not in matter]

    def holding(self, z: Array, held: Sequence[int]) -> 'Problem':
        """Return the problem of all variables but some, whose parameters stay as they are at z."""
        base = self.base
        for free, variable in ((self.freedoms[j], z[j]) for j in held):
            base = put(base, free.knob.parameter, free.value(variable), free.element)
        return replace(self, base=base, freedoms=tuple(
            free for j, free in enumerate(self.freedoms) if j not in held))

    def start(self) -> Array:
        """Return z of the given parameters."""
        return np.zeros(len(self.freedoms) + self.nuisances)

    def bounds(self) -> tuple[Array, Array]:
        """Return the lower and upper bounds of z."""
        width = START_BOUND[:self.nuisances]
        return (np.array([f.low for f in self.freedoms] + [-w for w in width]),
                np.array([f.high for f in self.freedoms] + list(width)))


def _on_grid(z: Array) -> Array:
    """Return the values of GRID that are nearest to these."""
    return np.round(z / GRID) * GRID
