# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The alarms of one valve: learning, detectors for every number, the promise and what is said."""

from collections.abc import Iterable, Mapping
import math
from typing import Any, NamedTuple

from .detector import FEWEST, Detector
from .learning import in_groups, join_of
from .summaries import LEVEL, REVERSAL, SPREAD, Summary, joined

YEAR = 365.25 * 86400.0
"""Seconds."""

WORDS = {
    LEVEL: 'is off by {size:+.2f} % of its span',
    REVERSAL: 'differs between up and down by {size:+.2f} % of its span',
    SPREAD: 'scatters {factor:.2f} times as much as before',
}


class Settings(NamedTuple):
    """What is promised, and of which valve."""

    false_alarms: float = 1.0
    """False alarms per valve-year, on average, at the most."""
    drift: float = 0.003
    """Declared drift of a level, a share of the span to either side: day and night, model error."""
    drift_of_reversal: float = 0.001
    """The same of the difference between up and down."""
    drift_of_spread: float = 0.1
    """The same of the logarithm of the spread."""
    block: float = 20.0
    """Length of a block, s."""
    learning: float = 3600.0
    """Time, s, of blocks by which the valve shows how it is while it is healthy."""

    def tolerance(self, kind: str) -> float:
        """Return the drift that is allowed for a kind of number."""
        return {LEVEL: self.drift, REVERSAL: self.drift_of_reversal,
                SPREAD: self.drift_of_spread}[kind]


class Alarm(NamedTuple):
    """An alarm: when it was given and since when it grew, s; where, and by how much."""

    time: float
    since: float
    channel: str
    kind: str
    shift: float

    @property
    def sentence(self) -> str:
        """What the valve does that it did not do before."""
        return f'{self.channel} ' + WORDS[self.kind].format(
            size=100.0 * self.shift, factor=math.exp(self.shift))


class Alarms:
    """
    Takes the summaries of blocks one after the other, and gives alarms at the promised rate.

    The promise (`detector`) holds for all numbers together. It is given once `learning` s have been
    seen and blocks were found that do not hang together; until then `lacking` says what is missing.
    """

    def __init__(self, settings: Settings, names: Iterable[tuple[str, str]]) -> None:
        self.settings = settings
        self.names = tuple(names)
        self.alarms: list[Alarm] = []
        self.blocks = 0
        """Blocks that were judged, after they had been joined."""
        self._first: list[Summary] = []
        self._waiting: list[Summary] = []
        self.join: int | None = None
        """Blocks that are judged as one; None while that is being learnt."""
        self._detectors: dict[tuple[str, str], Detector] = {}
        self._cells: dict[str, tuple[int, int]] = {}

    @property
    def promised(self) -> bool:
        """Whether the rate of false alarms is promised now."""
        return self.join is not None

    @property
    def seen(self) -> int:
        """Blocks that have come in, of which `as_values` tells."""
        return self.blocks + len(self._first) + len(self._waiting)

    @property
    def lacking(self) -> str:
        """What keeps the alarms from promising or from seeing anything, '' for nothing."""
        if self.join is None:
            seen = self.settings.block * len(self._first)
            if seen < self.settings.learning:
                return f'learning: {seen:.0f} of {self.settings.learning:.0f} s'
            return ('residuals hang together for longer than blocks of this length: no rate of '
                    'false alarms can be promised yet')
        for channel, cell in self._cells.items():
            known = max((one.compared_with(cell) for name, one in self._detectors.items()
                         if name[0] == channel), default=FEWEST)
            if known < FEWEST:
                return (f'this operating point of {channel} is new: {known} of {FEWEST} blocks to '
                        'compare with')
        return ''

    @property
    def evidence(self) -> float:
        """The largest evidence now, as a share of what makes an alarm, both as logarithms."""
        return max((max(one.log_evidence, 0.0) / math.log(one.threshold)
                    for one in self._detectors.values()), default=0.0)

    def note(self, block: Summary) -> list[Alarm]:
        """Take the next block; return the alarms that it makes."""
        if self.join is None:
            self._learn(block)
            return []
        if self._waiting and block.begin - self._waiting[-1].end > self.settings.block:
            self._waiting = []
        self._waiting.append(block)
        if len(self._waiting) < self.join:
            return []
        whole, self._waiting = joined(self._waiting), []
        return self._judge(whole)

    def _learn(self, block: Summary) -> None:
        self._first.append(block)
        # asked again after as many more where it was not enough
        every = max(int(self.settings.learning / self.settings.block), 24)
        count = len(self._first)
        if count < every or count % every:
            return
        self.join = join_of(self._first)
        if self.join is None:
            self._first = self._first[-4 * every:]
            return
        self._detectors = self._new_detectors(self.join)
        for one in in_groups(self._first, self.join):
            self._judge(one)
        self._first = []

    def _new_detectors(self, join: int) -> dict[tuple[str, str], Detector]:
        length = self.settings.block * join
        threshold = len(self.names) * YEAR / length / self.settings.false_alarms
        return {name: Detector(self.settings.tolerance(name[1]), threshold, seed)
                for seed, name in enumerate(self.names)}

    def as_values(self) -> dict[str, Any]:
        """Return what has been learnt as plain values, for `restored`."""
        return {
            'settings': list(self.settings), 'names': [list(name) for name in self.names],
            'join': self.join, 'blocks': self.blocks, 'cells': self._cells,
            'first': [one.as_values() for one in self._first],
            'waiting': [one.as_values() for one in self._waiting],
            'detectors': [self._detectors[name].as_values() for name in self.names]
            if self._detectors else []}

    @classmethod
    def restored(
        cls, settings: Settings, names: Iterable[tuple[str, str]], values: Mapping[str, Any],
    ) -> 'Alarms | None':
        """Return the alarms that `as_values` told of; None if of other settings or numbers."""
        made = cls(settings, names)
        if (values['settings'] != list(settings)
                or values['names'] != [list(name) for name in made.names]):
            return None
        made.join, made.blocks = values['join'], int(values['blocks'])
        made._cells = {str(channel): (int(third), int(way))
                       for channel, (third, way) in values['cells'].items()}
        made._first = [Summary.restored(one) for one in values['first']]
        made._waiting = [Summary.restored(one) for one in values['waiting']]
        if made.join is not None:
            made._detectors = made._new_detectors(int(made.join))
            for name, one in zip(made.names, values['detectors'], strict=True):
                made._detectors[name].restore(one)
        return made

    def _judge(self, block: Summary) -> list[Alarm]:
        self.blocks += 1
        self._cells = block.cells
        found = []
        for name, detector in self._detectors.items():
            if name in block.numbers and detector.note(
                    block.begin, block.cells[name[0]], block.numbers[name]):
                found.append(Alarm(block.end, detector.since, *name, detector.shift))
        self.alarms = [*self.alarms, *found][-100:]
        return found
