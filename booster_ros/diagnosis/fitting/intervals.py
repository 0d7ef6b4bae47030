# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How sure a fitted parameter is, when residuals are coloured."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.freedom import Free
from booster_ros.diagnosis.fitting.valley import slopes_along_axes
from booster_ros.model.catalogue import EFFECTS, Knob
from booster_ros.model.parameters import DESCRIPTIONS

Array = np.ndarray

DRAWS = 400
LEVEL = 0.95

SAME_TRACE = 0.01
"""Largest share of the square of a size's trace that shapes leave of it if they do the same as
it."""

FEWEST_BLOCKS = 8
"""Number of segments below which segments are cut into equal parts: of two segments there are
three draws in all."""

FEW, IN_FEW = 3, 0.9
"""Number of segments, and share of what is known of the size of an effect: where so few segments
hold more than this share, segments are cut as well."""

WIDEST = 30.0
"""Standard deviation of a size before anything is seen of it, in typical sizes."""

SILENT = 1.0
"""Norm of the change of the scaled residuals for a typical size, below which slopes tell
nothing."""

NOTICED = 3.84
"""Rise of the cost from which the rows notice that a variable moves of which slopes tell nothing:
95 % of chi square."""

HALVINGS = 12

FLAT = 1e-12
"""Length of an axis of draws, relative to the longest, below which it is rounding."""

AT_BOUND = 1e-2
"""Distance of a size from its bound, relative to its range, below which it has run into it."""


@dataclass(frozen=True)
class Interval:
    """
    A value with its 95 % interval.

    With `open_above` anything from `low` up may be true, and none as well: a stiffness of none, or
    a restriction of none, is 0, and stands beyond all that is large. `high` is then the largest
    that is looked for.
    """

    value: float
    low: float
    high: float
    unit: str
    open_above: bool = False

    @property
    def is_none(self) -> bool:
        """Whether the value itself is none, as that of a stiffness may be."""
        return self.open_above and self.value < self.low

    def holds_none(self, knob: Knob) -> bool:
        """Tell whether what this knob turns may as well be none."""
        return self.open_above or self.low <= knob.neutral <= self.high


def block_bootstrap(problem: Problem, fit: Fit, of_row: Array) -> Array:
    """
    Return draws of z, shape (DRAWS, variables), by a block bootstrap of whole segments.

    `of_row` says of each row of the experiment which segment it belongs to. Each draw weighs the
    segments by how often they were drawn and makes one Gauss-Newton step from the fit. Residuals
    may be as coloured as they like within a segment. The value that is expected of a declared
    parameter is drawn too, from its prior: what an effect trades with it is as unsure as that.

    Shapes are drawn with all else free; all else is drawn with the shapes as they were found.
    Drawn together they would run along a line through nonsense: a drift of half the size in half
    the time is the same drift while it is young, and where the size is none the shape means
    nothing.
    """
    label = _labels(problem, _blocks(problem, fit, of_row))
    return _draws(problem, fit, problem.residuals(fit.z), fit.jacobian, label)


def block_bootstrap_of_means(problem: Problem, fit: Fit, of_row: Array) -> Array:
    """
    Return draws as `block_bootstrap` does, but from means, in which single slips do not show.

    Where the stem sticks, slopes of single rows say when slips come, as if the model could repeat
    each of them: intervals from such slopes are far too narrow.
    """
    of_row = _blocks(problem, fit, of_row)
    here = problem.means(fit.z)
    columns = problem.slopes_of_means(fit.z, here, problem.slopes_of_means(fit.z, here))
    slopes = slopes_along_axes(problem, problem.means, fit.z, here, columns)
    label = np.concatenate([
        of_row[rows][slips.first] for rows, slips in zip(problem.counted.values(), problem.slips)])
    return _draws(problem, fit, here, slopes, label)


def _blocks(problem: Problem, fit: Fit, of_row: Array) -> Array:
    """Return the block of each row: segments, cut where there are few or few of them tell."""
    segments = len(np.unique(of_row[problem.rows]))
    if segments < FEWEST_BLOCKS:
        of_row = _cut(of_row, -(-FEWEST_BLOCKS // segments))
    in_few = _shows_in_few(problem, fit, _labels(problem, of_row))
    return _cut(of_row, FEWEST_BLOCKS) if in_few else of_row


def _draws(problem: Problem, fit: Fit, residual: Array, jacobian: Array, label: Array
           ) -> Array:
    data = len(label)
    blocks = np.unique(label)
    size = len(fit.z)
    gradients = np.zeros((len(blocks), size))
    hessians = np.zeros((len(blocks), size, size))
    for b, k in enumerate(blocks):
        mask = np.flatnonzero(label == k)
        gradients[b] = jacobian[mask].T @ residual[mask]
        hessians[b] = jacobian[mask].T @ jacobian[mask]
    prior = jacobian[data:]
    prior_hessian = prior.T @ prior
    rng = np.random.default_rng(1)
    draws = np.empty((DRAWS, size))
    # sizes are held to their typical order: else one that hardly shows in a draw could be anything
    ridge = np.eye(size) / WIDEST**2
    pull = ridge @ fit.z
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape]
    rest = np.setdiff1d(np.arange(size), shapes)
    for d in range(DRAWS):
        counts = np.bincount(rng.integers(len(blocks), size=len(blocks)), minlength=len(blocks))
        centres = residual[data:] + rng.standard_normal(len(prior))
        gradient = counts @ gradients + prior.T @ centres + pull
        hessian = np.tensordot(counts, hessians, 1) + prior_hessian + ridge
        draws[d] = fit.z - np.linalg.solve(hessian, gradient)
        if shapes:
            draws[d, rest] = fit.z[rest] - np.linalg.solve(
                hessian[np.ix_(rest, rest)], gradient[rest])
    gradient = gradients.sum(axis=0) + prior.T @ residual[data:] + pull
    hessian = hessians.sum(axis=0) + prior_hessian + ridge
    room = np.array(problem.bounds()) - fit.z
    held = _held_back(hessian, gradient, room)
    if shapes:
        held[rest] = _held_back(hessian[np.ix_(rest, rest)], gradient[rest], room[:, rest])
    return draws + held


def _held_back(hessian: Array, gradient: Array, room: Array) -> Array:
    """
    Return by how much bounds hold back a Gauss-Newton step; `room` are its least and most.

    A size at its bound would go on beyond it, and all else with it. Draws around where it would
    go say that it is none with certainty; around where it has to stay, how much it may be.
    """
    # of a record with next to no noise, rounding leaves less of the flattest axes than the ridge
    squares, axes = np.linalg.eigh(hessian)
    lengths = np.sqrt(np.maximum(squares, 1.0 / WIDEST**2))
    aim = -(axes.T @ gradient) / lengths
    free = axes @ (aim / lengths)
    if np.all((room[0] <= free) & (free <= room[1])):
        return np.zeros(len(free))
    return np.asarray(lsq_linear(lengths[:, None] * axes.T, aim, (room[0], room[1])).x - free)


def _labels(problem: Problem, of_row: Array) -> Array:
    """Return the block of every residual of a measurement."""
    return np.concatenate([of_row[rows] for rows in problem.counted.values()])


def _shows_in_few(problem: Problem, fit: Fit, label: Array) -> bool:
    """
    Tell whether what is known of the size of an effect comes from few blocks.

    If a stem reaches its seat twice, say, one or more of 20 draws are without these blocks, know
    nothing of the size, and would call any trace chance.
    """
    sizes = [j for j, free in enumerate(problem.freedoms)
             if not free.knob.shape and not np.isfinite(free.sigma) and fit.seen[j]]
    known = fit.jacobian[:len(label), sizes]**2
    by_block = np.array([known[label == k].sum(axis=0) for k in np.unique(label)])
    in_few = np.sort(by_block, axis=0)[-FEW:].sum(axis=0)
    return bool((in_few > IN_FEW * by_block.sum(axis=0)).any())


def _cut(of_row: Array, parts: int) -> Array:
    """Return the segment of each row with every segment cut into equal parts."""
    finer = np.empty(len(of_row), dtype=int)
    for segment in np.unique(of_row):
        rows = np.flatnonzero(of_row == segment)
        finer[rows] = segment * parts + np.arange(len(rows)) * parts // len(rows)
    return finer


def interval_of(problem: Problem, draws: Array, fit: Fit, index: int,
                tried: tuple[float, float] | None = None) -> Interval:
    """
    Return the value and 95 % interval of a parameter, within its bounds.

    The interval is as long to either side, in z, as 95 % of the draws are off the fit. Of a few
    segments, some tell a parameter far better than others, and draws are skewed: their own 2.5 and
    97.5 % quantiles are off to the wrong side then, and hold the truth less often (Hall, 1992, The
    Bootstrap and Edgeworth Expansion, section 3.5). A fit that stopped early has draws around a
    step away from it: the interval holds both.

    `tried` are the ends (in z) of the good trials, where there were trials: these were drawn ever
    closer to the best, so that a share of them is no measure.

    The interval of a variable that shows nowhere where it stands, such as the lift of a seat that
    is never reached, goes to where the rows would notice it (profile likelihood, all else as it
    is). That of a stiffness or restriction that may as well be none is open above.
    """
    free = problem.freedoms[index]
    if tried is not None:
        low, high = tried
    elif np.linalg.norm(fit.jacobian[:, index]) < SILENT:
        low, high = _unnoticed(problem, fit, index)
    else:
        off = np.quantile(np.abs(draws[:, index] - fit.z[index]), LEVEL)
        low, high = fit.z[index] - off, fit.z[index] + off
    # trials need not hold a fit that is better than all of them
    ends = [free.value(float(np.clip(z, free.low, free.high)))
            for z in (min(low, fit.z[index]), max(high, fit.z[index]))]
    open_above = free.knob.inverse > 0 and free.knob.neutral in ends
    if open_above:
        ends = [free.knob.high if end == free.knob.neutral else end for end in ends]
    return Interval(free.value(fit.z[index]), min(ends), max(ends),
                    DESCRIPTIONS[free.knob.parameter].unit, open_above)


def _unnoticed(problem: Problem, fit: Fit, index: int) -> tuple[float, float]:
    """Return how far towards its bounds a variable can go before the rows notice."""
    most = problem.cost(fit.z) + NOTICED

    def unnoticed(end: float) -> bool:
        moved = fit.z.copy()
        moved[index] = end
        return problem.cost(moved) < most

    def furthest(bound: float) -> float:
        if unnoticed(bound):
            return bound
        inside, outside = float(fit.z[index]), bound
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if unnoticed(middle) else (inside, middle)
        return inside

    free = problem.freedoms[index]
    return furthest(free.low), furthest(free.high)


def undetermined(problem: Problem, draws: Array, fit: Fit, effect: str) -> str:
    """
    Return why this record does not show a fitted effect, '' where it does.

    An effect stands if the neutral values of its own sizes lie outside the region that holds 95 %
    of their draws, and if no size has run into its bound. One at its bound imitates something
    else, unless a shape does the same as the size, as while a drift is young. The region is that
    of all sizes together: two that do the same may each be anything, their sum may not, even where
    the fit gave all of it to one of them. A size that would not show at its typical value, nor
    shows as it stands, has no say.
    """
    own = own_sizes(effect)
    shows = fit.seen | (np.linalg.norm(fit.jacobian, axis=0) > SILENT)
    sizes = [j for j, free in enumerate(problem.freedoms)
             if free.knob.parameter in own and shows[j]]
    if not fit.seen[sizes].any() or _holds_zero(draws[:, sizes], fit.z[sizes]):
        return 'its size is not told from none'
    at_bound = [problem.freedoms[j].knob.parameter for j in sizes
                if _at_bound(problem.freedoms[j], fit.z[j])]
    alike = traded(problem, fit, effect) if at_bound else []
    stuck = [name for name in at_bound if name not in alike]
    return f'{stuck[0]} runs into its bound' if stuck else ''


def traded(problem: Problem, fit: Fit, effect: str) -> list[str]:
    """
    Return the effect's sizes whose trace its shapes can imitate: known only with those.

    Where the stem sticks, traces are those in means over many slips: in single rows a slip that
    comes a little later is far more than what tells a size from a shape.
    """
    traces = problem.means_of(fit.jacobian) if fit.sticks else fit.jacobian
    sizes, shapes = (
        [j for j, free in enumerate(problem.freedoms) if free.knob.parameter in wanted]
        for wanted in (sizes_of(effect), shapes_of(effect)))
    found = []
    for j in sizes:
        trace = traces[:, j]
        imitated = traces[:, shapes] @ np.linalg.lstsq(traces[:, shapes], trace)[0]
        if np.sum((trace - imitated)**2) < SAME_TRACE * np.sum(trace**2):
            found.append(problem.freedoms[j].knob.parameter)
    return found


def _holds_zero(draws: Array, best: Array) -> bool:
    """Tell whether zero is in the ellipsoid of 95 % of the draws, around their mean or the best."""
    mean = draws.mean(axis=0)
    # not from their covariance: of sizes that trade, the sum may be known a million times better
    _, lengths, axes = np.linalg.svd(draws - mean, full_matrices=False)
    told = lengths > FLAT * lengths[0]

    def distance(x: Array) -> Array:
        return np.sum((x @ axes[told].T / lengths[told])**2, axis=-1)

    widest = np.quantile(distance(draws - mean), LEVEL)
    return bool(min(distance(mean), distance(best)) <= widest)


def own_sizes(effect: str) -> set[str]:
    """Return those of `sizes_of` that no effect before this one in the catalogue has as well."""
    names = list(EFFECTS)
    return sizes_of(effect).difference(*(sizes_of(name) for name in names[:names.index(effect)]))


def sizes_of(effect: str) -> set[str]:
    """Return the parameters that give an effect its size; KeyError if there is no such effect."""
    return {knob.parameter for knob in EFFECTS[effect].knobs if not knob.shape}


def within(effect: str) -> set[str]:
    """Return the effects that this one builds on: those whose own sizes it has as well."""
    return {name for name in EFFECTS if name != effect and sizes_of(effect) & own_sizes(name)}


def left_of(effects: tuple[str, ...], name: str) -> tuple[str, ...]:
    """
    Return what is left of the effects where one of them, `name`, is not shown.

    The others, and those that it builds on: friction that does not differ along the travel is
    friction all the same.
    """
    others = tuple(effect for effect in effects if effect != name)
    return (*others, *(effect for effect in EFFECTS
                       if effect in within(name) and effect not in others))


def shapes_of(effect: str) -> set[str]:
    """Return the parameters that give an effect its shape; KeyError if there is no such effect."""
    return {knob.parameter for knob in EFFECTS[effect].knobs if knob.shape}


def _at_bound(free: Free, z: float) -> bool:
    """Tell whether a size has run into a bound that is not its neutral value."""
    room = AT_BOUND * (free.high - free.low)
    return (abs(free.low) > room and z - free.low < room) or (
        abs(free.high) > room and free.high - z < room)
