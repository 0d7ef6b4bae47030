# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Samples of a real valve, as they come over topics, put into rows in the order of their stamps."""

import bisect
import dataclasses
import math

import numpy as np

DRIVES = ('control_current', 'set_point')
"""Channels that stand from one sample to the next; readings are valid at their stamp alone."""

READINGS = ('back_pressure', 'supply_pressure', 'chamber_pressure', 'valve_position')
CHANNELS = (*DRIVES, *READINGS)

LONGEST_GAP = 0.5
"""Longest time, s, between two readings of a channel within which it is known: what it drives
begins anew after that, no row of a record is filled across it, and no time of a trial counts."""

SAMPLES_OF_A_GAP = 2.5
"""The same, in usual intervals between readings, where these are longer: one may be missing."""

Array = np.ndarray


@dataclasses.dataclass
class Counts:
    """What was wrong with the samples so far."""

    samples: int = 0
    late: int = 0
    """Came after the rows of their time had been used: not used."""
    unordered: int = 0
    """Came after a later one of their channel, and were put in order."""
    repeated: int = 0
    """Had the stamp of another one of their channel: not used."""
    not_finite: int = 0
    """NaN or infinite: not used."""
    jumps: int = 0
    """The clock jumped, or nothing came for long: the prediction begins anew."""


class Aligner:
    """
    Collects samples, and gives them out in rows once no earlier ones are to be expected.

    Samples whose stamps are within `merged` s are one row. Rows are held back for `patience` s of
    stamps. A stamp more than `jump` s ahead of the newest, or behind it, is a jump of the clock:
    what was waiting is given up, and time goes on from there.
    """

    def __init__(self, patience: float = 0.3, merged: float = 0.002, jump: float = 5.0) -> None:
        self.patience, self.merged, self.jump = patience, merged, jump
        self.counts = Counts()
        self._stamps: dict[str, list[float]] = {name: [] for name in CHANNELS}
        self._values: dict[str, list[float]] = {name: [] for name in CHANNELS}
        self._newest = -math.inf
        self._used = -math.inf
        self._standing = dict.fromkeys(DRIVES, math.nan)
        self.jumped = False
        """Whether the next rows do not go on from the last ones."""

    def add(self, channel: str, stamp: float, value: float) -> None:
        """Take a sample: stamp in s, value in SI units, pressures gauge."""
        counts = self.counts
        counts.samples += 1
        if not (math.isfinite(value) and math.isfinite(stamp)):
            counts.not_finite += 1
            return
        if math.isfinite(self._newest) and abs(stamp - self._newest) > self.jump:
            self._restart()
        if stamp <= self._used:
            counts.late += 1
            return
        stamps, values = self._stamps[channel], self._values[channel]
        place = bisect.bisect_left(stamps, stamp)
        if place < len(stamps):
            if stamps[place] == stamp:
                counts.repeated += 1
                return
            counts.unordered += 1
        stamps.insert(place, stamp)
        values.insert(place, value)
        self._newest = max(self._newest, stamp)

    def _restart(self) -> None:
        self.counts.jumps += 1
        self.jumped = True
        self._newest = self._used = -math.inf
        for name in CHANNELS:
            self._stamps[name].clear()
            self._values[name].clear()

    def longest_gap(self) -> float:
        """Return the longest gap, s, in what comes of this valve, by the samples that wait."""
        steps = np.diff(max((self._stamps[name] for name in READINGS), key=len))
        return max(LONGEST_GAP, SAMPLES_OF_A_GAP * float(np.median(steps))) if len(steps) else (
            LONGEST_GAP)

    def rows(self) -> dict[str, Array]:
        """
        Return the rows that are complete, shape (n,) each: `time` (s) and every channel.

        A reading without a sample is NaN; of a drive, the last sample up to the row stands.
        """
        until = self._newest - self.patience
        moments: set[float] = set()
        cut = {name: bisect.bisect_right(self._stamps[name], until) for name in CHANNELS}
        for name in CHANNELS:
            moments.update(self._stamps[name][:cut[name]])
        time = self._merged(sorted(moments))
        rows = {'time': np.array(time)}
        for name in CHANNELS:
            stamps, values = self._stamps[name][:cut[name]], self._values[name][:cut[name]]
            del self._stamps[name][:cut[name]], self._values[name][:cut[name]]
            column = np.full(len(time), math.nan)
            for stamp, value in zip(stamps, values):
                column[max(bisect.bisect_right(time, stamp) - 1, 0)] = value
            if name in DRIVES:
                column = self._held(name, column)
            rows[name] = column
        if time:
            self._used = until
        return rows

    def _merged(self, moments: list[float]) -> list[float]:
        kept: list[float] = []
        for moment in moments:
            if not kept or moment - kept[-1] > self.merged:
                kept.append(moment)
        return kept

    def _held(self, name: str, column: Array) -> Array:
        if not len(column):
            return column
        known = np.isfinite(column)
        last = np.maximum.accumulate(np.where(known, np.arange(len(column)), -1))
        held = np.where(last >= 0, column[last], self._standing[name])
        self._standing[name] = float(held[-1])
        return held
