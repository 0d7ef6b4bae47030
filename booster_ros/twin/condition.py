# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
In what condition a valve is, by the last minutes: figures to follow over months.

**Stem** (the valve signature). While the stem slides, the chamber pressure holds spring, friction
and damping the balance. By least squares over the rows in which it slides,

    p - p_h(x) = a + b x / L + f sign(v) + d v,

p_h(x) being the pressure at which the model's stem stands at x without friction and L the travel.
Friction is A f, the spring range p_h(0) + a to p_h(L) + a + b, and the dead band, the share of the
spring range by which the pressure changes at a reversal before the stem moves, 2 f over that range.

**Chamber.** The model is run beside the rows as it is, and with a bit of a leak, of a dead time,
and of another zero of the converter. What it misses of the chamber pressure is, to first order,

    r = - sum over j of theta_j dr / dtheta_j,

and least squares tell the theta_j: one step of Gauss and Newton. The zero is there so that it is
not taken for a leak.

**Command.** T86 is the median over the steps of set point or current: the time from a step to 86 %
of the way that the stem goes (ISA-75.25.01, EnTech Control Valve Dynamic Specification 3.0).

What the rows do not tell is NaN: friction without motion both ways, a leak without a drive, T86
without steps.
"""

from collections.abc import Mapping
import math
from typing import NamedTuple

import numpy as np

from ..metrics.segments import Course, levels, noise_level
from ..metrics.step_response import step_responses
from ..model.holding import holding_pressure
from ..model.sensors import position_behind, pressure_behind
from ..model.system import PositionerParameters
from ..signals.noise_level import white_noise
from .aligning import DRIVES
from .predictor import POSITION, PRESSURE, SMOOTHED, Predictor, smoothed
from .summaries import MOVES

Array = np.ndarray

MOST_ROWS = 6000
"""Rows that are used at the most, the last ones: a minute at 100 Hz, in which a wear that shows
over months stands still. They take 0.2 s of computing."""

FEWEST_ROWS = 20
"""Rows in which the stem slides up, and down, below which nothing is told of friction."""

NOISES = 5.0
"""Standard deviations of the noise of a velocity beyond which the stem slides: of noise alone, one
row in a million is."""

INSIDE = 0.01
"""Share of the travel at either end where a stop may hold the stem."""

ENOUGH_TRAVEL = 0.1
"""Share of the travel that the stem must cover to tell both ends of the spring range: else the
range is as wide as the model has it."""

STEPS = {'leak': 5e-8, 'dead_time': 0.02, 'zero': 1e3}
"""Small sizes with which the model is run, m², s and Pa; what is not told better is not told."""


class Condition(NamedTuple):
    """Figures of a valve in SI units, pressures gauge; NaN where the rows do not tell."""

    friction: float = math.nan
    dead_band: float = math.nan
    """Share of the spring range."""
    spring_range_low: float = math.nan
    spring_range_high: float = math.nan
    leak_area: float = math.nan
    dead_time: float = math.nan
    t86: float = math.nan

    @property
    def values(self) -> dict[str, float]:
        """What is told, by name and unit."""
        units = ('friction [N]', 'dead band', 'spring range, low [Pa]', 'spring range, high [Pa]',
                 'leak area [m^2]', 'dead time [s]', 'T86 [s]')
        return {name: value for name, value in zip(units, self) if math.isfinite(value)}


def condition(rows: Mapping[str, Array], p: PositionerParameters) -> Condition:
    """Return the condition by rows of a record (`time`, s, and channels in SI, NaN not read)."""
    if not rows:
        return Condition()
    last = {name: values[-MOST_ROWS:] for name, values in rows.items()}
    return Condition(*_stem(last, p), *_chamber(last, p), _t86(rows))


def _stem(rows: Mapping[str, Array], p: PositionerParameters) -> tuple[float, float, float, float]:
    """Return friction, N, dead band, and both ends of the spring range, Pa."""
    nothing = (math.nan,) * 4
    act = p.actuator
    if not {PRESSURE, POSITION} <= rows.keys() or act.travel <= 0.0:
        return nothing
    known = np.isfinite(rows[PRESSURE]) & np.isfinite(rows[POSITION])
    time, read = rows['time'][known], rows[POSITION][known]
    if len(time) < 2 * FEWEST_ROWS:
        return nothing
    position, velocity = smoothed(time, np.asarray(position_behind(p.sensors, read)))
    pressure, _ = smoothed(time, np.asarray(pressure_behind(p.sensors, rows[PRESSURE][known])))
    share = position / act.travel
    least = max(MOVES * act.travel, NOISES * _noise_of_velocity(time, white_noise(read)))
    slides = (np.abs(velocity) > least) & (share > INSIDE) & (share < 1.0 - INSIDE)
    up = velocity > 0.0
    if min(np.count_nonzero(slides & up), np.count_nonzero(slides & ~up)) < FEWEST_ROWS:
        return nothing
    grid = np.linspace(0.0, act.travel, 101)
    holding = np.array([holding_pressure(p, float(place), 0.0) for place in grid])
    beyond = pressure - np.interp(position, grid, holding)
    columns = [np.ones(len(time)), np.sign(velocity), velocity]
    tells_both = np.ptp(share[slides]) > ENOUGH_TRAVEL
    if tells_both:
        columns.append(share)
    found, *_ = np.linalg.lstsq(np.column_stack(columns)[slides], beyond[slides], rcond=None)
    low, high = holding[0] + found[0], holding[-1] + found[0] + (found[3] if tells_both else 0.0)
    rubs = max(float(found[1]), 0.0)
    return act.effective_area * rubs, 2.0 * rubs / (high - low), float(low), float(high)


def _noise_of_velocity(time: Array, noise: float) -> float:
    """Return the standard deviation of the slope of a straight line through a smoothing window."""
    step = float(np.median(np.diff(time)))
    size = 2 * max(int(0.5 * SMOOTHED / max(step, 1e-6)), 1) + 1
    return noise / step * math.sqrt(12.0 / (size * (size**2 - 1))) if step > 0.0 else math.inf


def _chamber(rows: Mapping[str, Array], p: PositionerParameters) -> tuple[float, float]:
    """Return the area of a leak, m², and the dead time, s."""
    act, converter = p.actuator, p.ep_converter
    changed = {
        'leak': p._replace(actuator=act._replace(leak_area=act.leak_area + STEPS['leak'])),
        'dead_time': p._replace(ep_converter=converter._replace(
            dead_time=converter.dead_time + STEPS['dead_time'])),
        'zero': p._replace(ep_converter=converter._replace(
            offset=converter.offset + STEPS['zero']))}
    missed = _missed(rows, p)
    if missed is None:
        return math.nan, math.nan
    shifts = {name: _missed(rows, one) - missed for name, one in changed.items()}
    known = np.isfinite([missed, *shifts.values()]).all(axis=0)
    told = {name: shift[known] for name, shift in shifts.items() if np.any(shift[known])}
    if np.count_nonzero(known) < FEWEST_ROWS or not told:
        return math.nan, math.nan
    matrix = np.column_stack(list(told.values()))
    sizes, *_ = np.linalg.lstsq(matrix, -missed[known], rcond=None)
    left = missed[known] + matrix @ sizes
    errors = np.sqrt(np.diag(np.linalg.pinv(matrix.T @ matrix)) * np.mean(left**2))
    found = {name: STEPS[name] * size for name, size, error in zip(told, sizes, errors)
             if error < 1.0}
    return (max(act.leak_area + found.get('leak', math.nan), 0.0),
            max(converter.dead_time + found.get('dead_time', math.nan), 0.0))


def _missed(rows: Mapping[str, Array], p: PositionerParameters) -> Array | None:
    """Return what the model misses of the chamber pressure, None where it says nothing of it."""
    driven = frozenset(rows) - {'time'}
    if not driven & {'control_current', 'back_pressure'}:
        return None
    return Predictor(p, driven).advance(rows).left.get(PRESSURE)


def _t86(rows: Mapping[str, Array]) -> float:
    """Return T86, s, over the steps of the command."""
    command = next((name for name in DRIVES if name in rows), None)
    if command is None or POSITION not in rows:
        return math.nan
    known = np.isfinite(rows[command]) & np.isfinite(rows[POSITION])
    course = Course(rows['time'][known], rows[command][known], rows[POSITION][known])
    if len(course.time) < FEWEST_ROWS:
        return math.nan
    found = [one.t86 for one in step_responses(course, levels(course), noise_level(course))
             if one.t86 is not None]
    return float(np.median(found)) if found else math.nan
