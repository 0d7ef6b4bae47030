# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The model beside the samples, each part driven by its measured upstream channel.

    current (and measured stem)  → E/P converter, booster, chamber → chamber pressure
    measured chamber pressure    → actuator, spring, stem          → valve position
    set point (no current and no pressure are measured)            → the closed loop → both

What drives is what lies behind a reading by the model: bias and span of a sensor are taken off. Of
a reading with play it is not known where the stem is; then the model's own stem goes with the
pressure.

A part whose drive is measured knows nothing of what is wrong above it, so that a fault shows in the
channel at whose part it is born (open-loop identification of a subsystem with a measured interface
variable; U. Forssell, L. Ljung, Automatica 35 (1999) 1215).
"""

from collections.abc import Mapping
import math
from typing import Any, NamedTuple

import numpy as np

from ..model.memory import CENTRED
from ..model.sensors import (
    position_behind, position_reading, pressure_behind, pressure_reading)
from ..model.start import start_of_readings
from ..model.stream import Stream
from ..model.system import PositionerParameters
from .aligning import LONGEST_GAP

Array = np.ndarray

PRESSURE, POSITION = 'chamber_pressure', 'valve_position'
READING = {PRESSURE: 'measured_chamber_pressure', POSITION: 'measured_valve_position'}
COMPARED = (PRESSURE, POSITION)

SMOOTHED = 0.1
"""Time, s, over which a measured channel is smoothed before it drives: its noise would else move
the stem, and has no velocity."""

TOLERANCE = 10.0
"""Factor on the solver's tolerance: it makes an error of 1 Pa and 0.5 um, far below what a measured
drive leaves anyway, at a quarter of the time."""

SETTLING = 5.0
"""Time, s, after a part has begun, in which what it says is not used: its start is read from noisy
samples, and what a reading does not tell has to die away."""


class Prediction(NamedTuple):
    """Rows of time, s, and of each compared channel what the model says, NaN where nothing."""

    time: Array
    said: dict[str, Array]
    read: dict[str, Array]
    """The readings themselves."""
    left: dict[str, Array]
    """Reading less what the model says, NaN where either is missing or a part settles."""

    def part(self, rows: slice) -> 'Prediction':
        """Return some of the rows."""
        return Prediction(self.time[rows], *(
            {name: values[rows] for name, values in one.items()} for one in self[1:]))

    def followed_by(self, next_rows: 'Prediction') -> 'Prediction':
        """Return these rows and those that come next."""
        return Prediction(np.concatenate([self.time, next_rows.time]), *(
            {name: np.concatenate([values, more[name]]) for name, values in one.items()}
            for one, more in zip(self[1:], next_rows[1:])))


class Predictor:
    """
    Steps the model of a valve beside rows of its samples, and begins anew where these break off.

    `driven` has the measured channels: those that never come are not waited for. A part begins anew
    where what drives it has come less often than every `gap` s.
    """

    def __init__(
        self, parameters: PositionerParameters, driven: frozenset[str], compiled: bool = True,
        settling: float = SETTLING, gap: float = LONGEST_GAP,
    ) -> None:
        self.parameters = parameters
        self.restarts = 0
        """How often a part has begun anew after a break."""
        self._parts = [_Part(parameters, role, compiled, settling, gap)
                       for role in roles(parameters, driven)]
        self._near: dict[str, Array] = {}
        """Rows before the next ones that are near enough to smooth these, the last of them not used
        yet for want of those behind."""
        self._used = -math.inf

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that are predicted."""
        return tuple(part.role.channel for part in self._parts)

    def restart(self) -> None:
        """Begin anew with the next rows, as after a jump of the clock."""
        self._near, self._used = {}, -math.inf
        for part in self._parts:
            part.stop()

    def advance(self, rows: Mapping[str, Array]) -> Prediction:
        """
        Go on over rows (`time`, s, and channels in SI, NaN where not read), rising in time.

        The last rows wait for the next call: a channel that drives is smoothed over what comes
        before and behind, and at the end of what is there its slope would be that of the noise.
        """
        rows = {name: np.concatenate([self._near[name], values]) if self._near else np.asarray(
            values, dtype=float) for name, values in rows.items()}
        time = rows['time']
        if not len(time):
            return Prediction(time, {}, {}, {})
        use = slice(int(np.searchsorted(time, self._used, 'right')),
                    int(np.searchsorted(time, time[-1] - 0.5 * SMOOTHED, 'right')))
        said, read, left = {}, {}, {}
        for part in self._parts:
            name = part.role.channel
            told, settled = part.advance(rows, use)
            said[name], read[name] = told[use], rows[name][use]
            left[name] = np.where(settled[use], read[name] - said[name], math.nan)
        self.restarts = sum(max(part.starts - 1, 0) for part in self._parts)
        if use.stop > use.start:
            self._used = float(time[use.stop - 1])
        near = time >= self._used - SMOOTHED
        self._near = {name: values[near] for name, values in rows.items()}
        return Prediction(time[use], said, read, left)


class Role(NamedTuple):
    """A part of the model: what it predicts, what commands it, which readings it is given."""

    channel: str
    command: str
    pinned: tuple[str, ...]


def roles(p: PositionerParameters, driven: frozenset[str]) -> tuple[Role, ...]:
    """Return the parts of the model that these measured channels allow to be compared."""
    if 'control_current' not in driven and not driven & {'back_pressure', PRESSURE}:
        if not p.position_controller.enabled or 'set_point' not in driven:
            return ()
        return tuple(Role(name, 'set_point', ()) for name in COMPARED if name in driven)
    found = []
    supply = tuple(name for name in ('supply_pressure',) if name in driven)
    if PRESSURE in driven and driven & {'control_current', 'back_pressure'}:
        above = tuple(name for name in ('back_pressure',) if name in driven)
        stem = tuple(name for name in (POSITION,)
                     if name in driven and p.sensors.position_backlash == 0.0)
        found.append(Role(PRESSURE, 'control_current', (*above, *supply, *stem)))
    if POSITION in driven and PRESSURE in driven:
        found.append(Role(POSITION, 'control_current', (PRESSURE,)))
    elif POSITION in driven:
        above = tuple(name for name in ('back_pressure',) if name in driven)
        found.append(Role(POSITION, 'control_current', (*above, *supply)))
    return tuple(found)


class _Part:
    """One part: its stream, and the last rows of what drives it."""

    def __init__(self, p: PositionerParameters, role: Role, compiled: bool, settling: float,
                 gap: float) -> None:
        loop = role.command == 'set_point'
        self._p = p if loop else p._replace(
            position_controller=p.position_controller._replace(enabled=False))
        self.role = role
        self.starts = 0
        self._compiled, self._settling, self._gap = compiled, settling, gap
        self._needs_command = loop or not set(role.pinned) & {'back_pressure', PRESSURE}
        self.stop()

    def stop(self) -> None:
        self._stream: Stream | None = None
        self._began = math.nan
        self._last = math.nan

    def advance(self, rows: Mapping[str, Array], use: slice) -> tuple[Array, Array]:
        """
        Return what the part says at these rows, and whether it has settled there.

        It goes on over the rows `use`; those beside them smooth, and have NaN.
        """
        time = rows['time']
        said, settled = np.full(len(time), math.nan), np.zeros(len(time), dtype=bool)
        usable = np.ones(len(time), dtype=bool)
        for name in self.role.pinned:
            usable &= np.isfinite(rows[name])
        command = rows[self.role.command] if self._needs_command else np.zeros(len(time))
        usable &= np.isfinite(command)
        places = np.flatnonzero(usable)
        if not len(places):
            return said, settled
        breaks = np.flatnonzero(np.diff(time[places]) > self._gap) + 1
        for piece in np.split(places, breaks):
            inside = (piece >= use.start) & (piece < use.stop)
            if not inside.any():
                continue
            if not time[piece[inside][0]] - self._last <= self._gap:
                self.stop()
            there = piece[inside]
            said[there], settled[there] = self._run(command, rows, piece, inside)
        return said, settled

    def _run(self, command: Array, rows: Mapping[str, Array], piece: Array, inside: Array
             ) -> tuple[Array, Array]:
        near = rows['time'][piece]
        pinned = {}
        for name in self.role.pinned:
            behind = self._behind(name, rows[name][piece])
            pinned[name], slope = (values[inside] for values in smoothed(near, behind))
            if name == POSITION:
                pinned['stem_velocity'] = slope
        piece = piece[inside]
        time = rows['time'][piece]
        if self._stream is None:
            self._begin(time[0], command[piece[0]], rows, piece, pinned)
        assert self._stream is not None
        seen = self._stream.advance(time, command[piece], pinned)
        self._last = float(time[-1])
        return seen[READING[self.role.channel]], time - self._began >= self._settling

    def _behind(self, name: str, readings: Array) -> Array:
        """Return what lies behind readings by the sensors of the model."""
        behind: Mapping[str, Any] = {PRESSURE: pressure_behind, POSITION: position_behind}
        return behind[name](self._p.sensors, readings) if name in behind else readings

    def _begin(self, time: float, command: float, rows: Mapping[str, Array], piece: Array,
               pinned: Mapping[str, Array]) -> None:
        read = {name: float(np.nanmean(values[piece][:10])) for name, values in rows.items()
                if name in COMPARED and np.isfinite(values[piece][:10]).any()}
        reading = {PRESSURE: pressure_reading, POSITION: position_reading}
        read |= {name: reading[name](self._p.sensors, float(values[0]))
                 for name, values in pinned.items() if name in COMPARED}
        start, departure = dict(read), CENTRED
        if self.role.command != 'set_point':
            start, departure = start_of_readings(self._p, time, command, read)
        start |= {name: float(values[0]) for name, values in pinned.items()}
        self._stream = Stream(self._p, time, command, start, tuple(pinned), TOLERANCE,
                              self._compiled, departure)
        self._began = time
        self.starts += 1


def smoothed(time: Array, values: Array) -> tuple[Array, Array]:
    """
    Return value and slope of the straight line through the samples about each one.

    The window holds the samples within half of `SMOOTHED` s to either side, one at the least; at
    the ends it is cut. Shapes (n,); the slope is in units per s, 0 for a single sample.
    """
    n = len(time)
    if n < 2:
        return values.astype(float), np.zeros(n)
    step = max(float(np.median(np.diff(time))), 1e-6)
    half = max(int(0.5 * SMOOTHED / step), 1)
    first = np.maximum(np.arange(n) - half, 0)
    last = np.minimum(np.arange(n) + half, n - 1)
    count = (last - first + 1).astype(float)
    origin_t, origin_v = float(time[0]), float(values[0])
    t, v = time - origin_t, values - origin_v

    def over(series: Array) -> Array:
        total = np.concatenate(([0.0], np.cumsum(series)))
        return (total[last + 1] - total[first]) / count

    mean_t, mean_v = over(t), over(v)
    spread = over(t * t) - mean_t**2
    slope = np.divide(over(t * v) - mean_t * mean_v, spread, out=np.zeros(n), where=spread > 0.0)
    return origin_v + mean_v + slope * (t - mean_t), slope
