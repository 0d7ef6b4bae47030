# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What can be done with a valve under test, wherever it runs."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from .series import Sample, Series

Controller = Callable[[Sample], float]
"""Returns the current (A) to send after a sample."""


class Band(NamedTuple):
    """Half widths within which a valve counts as settled: Pa, m."""

    chamber_pressure: float = 100.0
    valve_position: float = 1e-5


DEFAULT_BAND = Band()


class Bench(ABC):
    """A valve that is advanced tick by tick; all times are simulated seconds."""

    def __init__(self) -> None:
        self.series = Series()
        """What was published since the start or the last reset."""
        self.period = 0.0
        """Seconds from one sample to the next."""

    @abstractmethod
    def send(self, current: float) -> None:
        """Command a current, A, from the next tick on."""

    @abstractmethod
    def step(self, ticks: int = 1) -> Sample:
        """Advance by so many ticks and return the last sample."""

    @abstractmethod
    def reset(self) -> Sample:
        """Go to the initial state with all faults off, and return its sample."""

    @abstractmethod
    def set(self, values: Mapping[str, Any]) -> None:
        """Set parameters (by dotted name) together; AssertionError where they are refused."""

    @abstractmethod
    def inject(self, fault: str, **fields: Any) -> None:
        """Switch a fault on from the next tick on; fields as in docs/faults.md."""

    @abstractmethod
    def clear(self) -> None:
        """Switch all faults off."""

    @property
    def now(self) -> Sample:
        """The last sample."""
        return self.series.last

    def run(self, seconds: float, controller: Controller | None = None) -> Series:
        """
        Advance for so many seconds, and return the samples of this time.

        A `controller` is asked before each tick; without one the last command stands.
        """
        found = Series()
        for _ in range(max(1, round(seconds / self.period))):
            if controller is not None:
                self.send(controller(self.now))
            found.append(self.step())
        return found

    def settle(
        self, controller: Controller | None = None, hold: float = 1.0, timeout: float = 60.0,
        band: Band = DEFAULT_BAND,
    ) -> Sample:
        """
        Advance until pressure and position have stayed within `band` for `hold` seconds.

        AssertionError, with how far they moved last, if that does not happen within `timeout`.
        """
        count = max(2, round(hold / self.period))
        recent: list[Sample] = []
        for _ in range(max(count, round(timeout / self.period))):
            if controller is not None:
                self.send(controller(self.now))
            recent = [*recent[1 - count:], self.step()]
            if len(recent) == count and _spread(recent, band) <= 1.0:
                return self.now
        moved = ', '.join(
            f'{name} moved by {2.0 * half * _spread(recent, band, name):g}'
            for name, half in band._asdict().items())
        raise AssertionError(
            f'not settled after {timeout:g} s: in the last {hold:g} s {moved}')


def _spread(samples: list[Sample], band: Band, only: str = '') -> float:
    """Return the largest range of a column as a share of what its band allows."""
    largest = 0.0
    for name, half in band._asdict().items():
        if only in ('', name):
            column = [getattr(sample, name) for sample in samples]
            largest = max(largest, (max(column) - min(column)) / (2.0 * half))
    return largest
