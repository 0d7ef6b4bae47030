# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Fitting parameters of the model to an experiment.

A fit minimises, over a vector of dimensionless variables z,

    sum over channels and marked rows ((measured - model(z)) / noise)²  +  sum (prior)²

by bounded trust-region least squares (scipy), with the columns of the Jacobian simulated side by
side: the compiled model releases Python's lock.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment, Initial
from booster_ros.diagnosis.fitting.descent import CONVERGED, Descent, Residuals, descend
from booster_ros.diagnosis.fitting.dormant import place_beyond
from booster_ros.diagnosis.fitting.freedom import BENCH, Free, possible_departures, put
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.fitting.slips import Windows
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.discrepancy import remembers
from booster_ros.model.memory import Departure
from booster_ros.model.parameters import is_consistent
from booster_ros.model.sensors import position_behind, pressure_behind
from booster_ros.model.start import rests_on_a_stop
from booster_ros.model.stream import DEFAULT_TOLERANCE
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

DIFFERENCE = 2e-3
VISIBLE, VISIBLE_THINNED, VISIBLE_THROUGH_SLIPS = 1.0, 10.0, 100.0
"""
Steps of the Jacobian's differences: DIFFERENCE is the first step in z, the others say how far
later steps go (norm of the change of the scaled residuals) on all rows, on thinned rows, and where
the stem sticks. Over larger steps columns bend: where gain, offset and supply nearly do the same,
what is left of their columns is wrong then, and a fit ends far from the end of their valley.
Smaller steps drown in the solver's own error, which is larger on thinned rows; where the stem
sticks, in a cost that is rough with the timing of slips: the third figure sees through that.
"""

FEW_EVALUATIONS = 6
"""Evaluations up to which a fit shows which way things go, and does not look beyond its end."""

FAINT = 1.0
"""Norm of the change of the scaled residuals below which the model is run to tell whether anything
moves."""

UNSEEN = 1.0
"""Rise of the cost without a size, up to which the size is not seen."""

SMALLEST_DIFFERENCE, LARGEST_DIFFERENCE = 2e-5, 0.1

START = np.array([3.0, 4.0, 1.0, 1.0, 2.0, 1.0])
"""Standard deviations of the start around the experiment's: chamber pressure in 100 Pa, back
pressure in 500 Pa, places in the two plays, warmth of the chamber's air in 10 K, what a term
remembers in 0.3 units of `past`."""

START_BOUND = (np.inf, np.inf, 1.0, 1.0, 10.0, 5.0)

GRID = 2.0**-27
"""
Distance between values of z with which the model is run. Linear algebra rounds differently from
run to run, and where the stem sticks a difference in the last bit becomes another slip.
"""

FAR = 1e3
"""Scaled residual where the model cannot run: large, finite, flat, so that a fit turns away."""


@dataclass(frozen=True)
class Fit:
    """A fitted model: z, the parameters and the start at z, and how well it does."""

    freedoms: tuple[Free, ...]
    z: Array
    parameters: PositionerParameters
    initial: Initial
    cost: float
    jacobian: Array = field(repr=False)

    @property
    def seen(self) -> Array:
        """Which variables move the scaled residuals by more than noise, compared with z = 0."""
        return np.linalg.norm(self.jacobian, axis=0) * np.abs(self.z) > 1.0

    @property
    def sticks(self) -> bool:
        """Whether the stem can stick: costs are rough then, and when a slip comes is chance."""
        return has_dry_friction(self.parameters.actuator)


@dataclass(frozen=True)
class Problem:
    """
    What is to be fitted: an experiment, the rows that count, and the given parameters.

    With `fine`, slopes are formed over short steps where the stem sticks as well: for an end that
    is compared with another end to a few percent, not for getting there.
    """

    experiment: Experiment
    rows: Array
    base: PositionerParameters
    freedoms: tuple[Free, ...]
    fine: bool = False

    @property
    def nuisances(self) -> int:
        """Number of variables for the start, behind those of the parameters."""
        return 0 if 'chamber_pressure' in self.experiment.pinned else len(START)

    def until(self, time: float) -> 'Problem':
        """Return this problem on the rows up to this time, s."""
        part = self.experiment.until(time)
        return replace(self, experiment=part, rows=self.rows[:len(part.time)])

    def parameters(self, z: Array) -> PositionerParameters:
        """Return the parameters at z, to GRID."""
        p = self.base
        for free, variable, nearest in zip(self.freedoms, z, _on_grid(z)):
            low, high = min(variable, free.low), max(variable, free.high)  # no step out of bounds
            value = free.value(min(max(nearest, low), high))
            p = put(p, free.knob.parameter, value, free.element)
        return p

    def initial(self, z: Array, p: PositionerParameters) -> Initial:
        """Return the start at z; a stem that can stick stands where it was seen, off the stops."""
        start = self.experiment.initial
        if self.nuisances:
            pressure, back, ep_play, position_play, warmth, past = _on_grid(
                z[len(self.freedoms):])
            back = start.departure.back_pressure + 500.0 * back
            start = replace(
                start, departure=Departure(back, ep_play, position_play, 10.0 * warmth, 0.3 * past),
                chamber_pressure=pressure_behind(
                    p.sensors, start.chamber_pressure + 100.0 * pressure))
        if start.valve_position is None or not has_dry_friction(p.actuator):
            return replace(start, valve_position=None)
        sensors = p.sensors
        read = position_behind(sensors, start.valve_position)
        stem = read - 0.5 * sensors.position_backlash * start.departure.position_play
        on_stop = rests_on_a_stop(p, start.chamber_pressure, stem)
        return replace(start, valve_position=None if on_stop else stem)

    def predict(self, z: Array) -> dict[str, Array] | None:
        """Return the model's channels at z, None where it cannot run."""
        return self._predicted(z, self.experiment)

    def _predicted(self, z: Array, experiment: Experiment) -> dict[str, Array] | None:
        p = self.parameters(z)
        return experiment.predict(p, self.initial(z, p)) if is_consistent(p) else None

    def residuals(self, z: Array) -> Array:
        """Return the scaled residuals of all marked rows, followed by the priors."""
        return self._with_priors(z, self._scaled(z))

    def means(self, z: Array) -> Array:
        """Return means of the residuals over windows, scaled to the noise of means, and priors."""
        return self._with_priors(z, [
            slips.means(scaled) for slips, scaled in zip(self.slips, self._scaled(z))])

    def through_slips(self, z: Array) -> Array:
        """Return what does not depend on when each slip comes: means, strengths, and priors."""
        scaled = self._scaled(z)
        means = [slips.means(each) for slips, each in zip(self.slips, scaled)]
        strengths = [slips.strengths(each) for slips, each in zip(self.slips, scaled)]
        return self._with_priors(z, [*means, *strengths])

    def cost(self, z: Array) -> float:
        """Return the sum of squares of `residuals`."""
        return float(np.sum(self.residuals(z)**2))

    def cost_of_means(self, z: Array) -> float:
        """Return the sum of squares of `means`."""
        return float(np.sum(self.means(z)**2))

    def cost_through_slips(self, z: Array) -> float:
        """Return the sum of squares of `through_slips`: what is missed apart from single slips."""
        return float(np.sum(self.through_slips(z)**2))

    @cached_property
    def counted(self) -> dict[str, Array]:
        """The rows of each channel that count, as a mask of shape (n,): marked, with a value."""
        return {name: self.rows & np.isfinite(measured)
                for name, measured in self.experiment.measured.items()}

    @cached_property
    def _decisive(self) -> Experiment:
        """The experiment up to the last row that counts: what comes later changes none of them."""
        counting = np.flatnonzero(np.any(list(self.counted.values()), axis=0))
        return self.experiment.until(self.experiment.time[counting[-1] if len(counting) else 0])

    @cached_property
    def slips(self) -> tuple[Windows, ...]:
        """The windows of rows, for each channel, over which means and strengths are formed."""
        measured, noise = self.experiment.measured, self.experiment.noise
        return tuple(Windows.of(self.experiment.time[rows], measured[name][rows] / noise[name])
                     for name, rows in self.counted.items())

    def slopes_of_means(self, z: Array, here: Array, before: Array | None = None) -> Array:
        """Return d(means)/dz as `jacobian` does; `here` are the means at z."""
        return self._slopes(self.means, z, here, before)

    def means_of(self, slopes: Array) -> Array:
        """Return the means over windows of slopes of rows, priors left out, as those of `means`."""
        ends = np.cumsum([len(slips.window) for slips in self.slips])
        return np.concatenate([
            np.apply_along_axis(slips.means, 0, part)
            for slips, part in zip(self.slips, np.split(slopes[:ends[-1]], ends[:-1]))])

    def slopes_through_slips(self, z: Array, here: Array, before: Array | None = None) -> Array:
        """Return d(through_slips)/dz as `jacobian` does; `here` is that at z."""
        return self._slopes(self.through_slips, z, here, before)

    def _scaled(self, z: Array) -> list[Array]:
        """Return the scaled residuals of the rows that count, one array a channel."""
        predicted = self._predicted(z, self._decisive)
        if predicted is None:
            return [np.full(np.count_nonzero(rows), FAR) for rows in self.counted.values()]
        measured, noise = self.experiment.measured, self.experiment.noise
        return [
            np.nan_to_num(
                (measured[name][rows] - predicted[name][rows[:len(predicted[name])]])
                / noise[name], nan=FAR, posinf=FAR, neginf=-FAR)
            for name, rows in self.counted.items()]

    def _with_priors(self, z: Array, parts: list[Array]) -> Array:
        priors = [variable / free.sigma for free, variable in zip(self.freedoms, z)
                  if np.isfinite(free.sigma)]
        start = z[len(self.freedoms):] / START if self.nuisances else []
        return np.concatenate([*parts, priors, start])

    def cost_of_priors(self, z: Array) -> float:
        """Return the cost of the departures at z from what is given, start included."""
        return float(np.sum(self._with_priors(z, [])**2))

    def jacobian(self, z: Array, here: Array, before: Array | None = None) -> Array:
        """
        Return d(residuals)/dz by one-sided differences, columns side by side.

        `here` are the residuals at z; `before` is an earlier Jacobian, which tells how far to step
        in each variable.
        """
        return self._slopes(self.residuals, z, here, before)

    def _slopes(self, residuals: Residuals, z: Array, here: Array, before: Array | None) -> Array:
        steps = np.full(len(z), DIFFERENCE) if before is None else self.steps_for(
            z, np.linalg.norm(before, axis=0))

        _, high = self.bounds()

        def column(j: int) -> Array:
            step = steps[j] if z[j] + steps[j] <= high[j] else -steps[j]
            moved = z.copy()
            moved[j] += step
            return (residuals(moved) - here) / step

        silent = self._silent(z)
        columns = np.zeros((len(here), len(z)))
        told = [j for j in range(len(z)) if j not in silent]
        for j, change in zip(told, side_by_side(column, told)):
            columns[:, j] = change
        for j in silent:  # such a variable moves its prior alone
            columns[len(here) + j - len(z), j] = 1.0 / START[j - len(self.freedoms)]
        return columns

    def steps_for(self, z: Array, slopes: Array) -> Array:
        """Return how far to step for differences, in z, where slopes have these norms."""
        return _on_grid(np.clip(self._visible(z) / np.maximum(slopes, 1e-9),
                                SMALLEST_DIFFERENCE, LARGEST_DIFFERENCE))

    def _visible(self, z: Array) -> float:
        rough = has_dry_friction(self.parameters(z).actuator) and not self.fine
        if rough:
            return VISIBLE_THROUGH_SLIPS
        return VISIBLE_THINNED if self.experiment.tolerance > DEFAULT_TOLERANCE else VISIBLE

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

    def idle(self, variables: Iterable[int], z: Array) -> set[int]:
        """Return those on which nothing seen at z depends: without a size no shape matters."""
        asked = list(variables)
        here = self._scaled(z) if asked else []

        def moves_nothing(j: int) -> bool:
            moved = z.copy()
            moved[j] += DIFFERENCE if z[j] + DIFFERENCE < self.freedoms[j].high else -DIFFERENCE
            return all(map(np.array_equal, self._scaled(moved), here))

        return {j for j, still in zip(asked, side_by_side(moves_nothing, asked)) if still}

    def without_unseen(self, fit: Fit) -> Fit:
        """
        Return the fit with those sizes back at neutral that the rows show less than their noise.

        And with those shapes typical on which nothing depends. Its slopes are those of before:
        nothing seen has moved.

        Slopes also call a size unseen that lies where nothing more changes, such as that of a seat
        so wide that it is never fully open, though a neutral seat is not wide enough. So the model
        with the size at neutral is run before it is taken.
        """
        seen = fit.seen
        z = fit.z
        cost = self.cost(z)
        for j, free in enumerate(self.freedoms):
            size = not np.isfinite(free.sigma) and not free.knob.shape
            if size and z[j] != 0.0 and not seen[j] and free.knob.parameter not in BENCH:
                without = z.copy()
                without[j] = 0.0
                if self.cost(without) < cost + UNSEEN:
                    z = without
        shapes = [j for j, free in enumerate(self.freedoms)
                  if free.knob.shape and not np.isfinite(free.sigma)
                  and not free.knob.inverse]  # a stiffness of none is rigid, and matters
        for j in self.idle(shapes, z):
            z = z.copy()
            z[j] = self.freedoms[j].without_size
        p = self.parameters(z)
        return replace(fit, z=z, parameters=p, initial=self.initial(z, p), cost=self.cost(z))

    def rows_counted(self) -> int:
        """Return how many measurements count, over all channels."""
        return sum(int(np.count_nonzero(rows)) for rows in self.counted.values())

    def mean_square(self, fit: Fit) -> float:
        """Return the cost of a fit to these rows for each that counts, priors included."""
        return fit.cost / max(self.rows_counted(), 1)

    def start(self) -> Array:
        """Return z of the given parameters."""
        return np.zeros(len(self.freedoms) + self.nuisances)

    def bounds(self) -> tuple[Array, Array]:
        """Return the lower and upper bounds of z."""
        width = START_BOUND[:self.nuisances]
        return (np.array([f.low for f in self.freedoms] + [-w for w in width]),
                np.array([f.high for f in self.freedoms] + list(width)))

    def at(self, z: Array) -> Fit:
        """Return z as a fit, with its cost and Jacobian there."""
        p, here = self.parameters(z), self.residuals(z)
        return Fit(self.freedoms, z, p, self.initial(z, p), float(here @ here),
                   self.jacobian(z, here))

    def fit(self, z: Array | None = None, evaluations: int = 20, converged: float = CONVERGED
            ) -> Fit:
        """
        Return the best fit from z on (default: from the given parameters).

        A fit that is given more than a few evaluations goes on where a declared parameter would
        begin to move something (`dormant`), if it ends better from there.
        """
        def descended(begin: Array) -> Descent:
            return descend(self.residuals, self.jacobian, self._inside(begin), *self.bounds(),
                           evaluations, converged)

        found = descended(self.start() if z is None else z)
        beyond = place_beyond(
            self.residuals, found.z, found.jacobian, self._dormant(found), self.bounds()
        ) if evaluations > FEW_EVALUATIONS else None
        if beyond is not None:
            found = min(found, descended(beyond), key=lambda end: end.cost)
        p = self.parameters(found.z)
        return Fit(self.freedoms, found.z, p, self.initial(found.z, p), found.cost, found.jacobian)

    def _dormant(self, found: Descent) -> dict[int, float]:
        """Return which declared parameters move nothing but their priors, and their tolerances."""
        # a Jacobian that was corrected by steps has next to nothing in their columns, not nothing
        faint = np.linalg.norm(found.jacobian[:self.rows_counted()], axis=0) < FAINT
        asked = [j for j, free in enumerate(self.freedoms) if np.isfinite(free.sigma) and faint[j]]
        return {j: self.freedoms[j].sigma for j in self.idle(asked, found.z)}

    def fit_through_slips(self, z: Array, evaluations: int = 20) -> Fit:
        """
        Return the end of a fit of `through_slips` from z or, if better, a fit of all rows from it.

        The means show how much friction there is, the strengths how far slips go. The timing of
        slips makes the cost of all rows rough, and a fit of all rows ends where the phase of some
        slips happens to suit, or where slips are so small that their phase does not matter;
        `cost_through_slips` says which of the two ends is better.
        """
        found = descend(self.through_slips, self.slopes_through_slips, self._inside(z),
                        *self.bounds(), evaluations)
        further = self.fit(found.z, evaluations)
        return self.at(found.z) if found.cost <= self.cost_through_slips(further.z) else further

    def _inside(self, z: Array) -> Array:
        low, high = self.bounds()
        margin = 1e-6 * np.minimum(high - low, 1.0)
        return np.clip(z, low + margin, high - margin)


def _on_grid(z: Array) -> Array:
    """Return the values of GRID that are nearest to these."""
    return np.round(z / GRID) * GRID
