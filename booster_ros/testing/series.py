# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a valve under test did: its samples, and assertions that say when and by how much."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np


class Sample(NamedTuple):
    """One sample as it is published: s of simulated time, A, Pa gauge, m."""

    time: float
    control_current: float
    chamber_pressure: float
    valve_position: float


class Series:
    """
    Samples in the order in which they came; `series['valve_position']` is one column, shape (n,).

    After a reset time begins again at 0, and so does the series.
    """

    def __init__(self) -> None:
        self._samples: list[Sample] = []

    def append(self, sample: Sample) -> None:
        """Add a sample."""
        self._samples.append(sample)

    def clear(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def since(self, time: float) -> 'Series':
        """Return the samples from `time` (s) on."""
        found = Series()
        found._samples = [sample for sample in self._samples if sample.time >= time]
        return found

    def tobytes(self) -> bytes:
        """Return all numbers, bit by bit: two equal runs give the same bytes."""
        return np.array(self._samples).tobytes()

    def assert_between(self, column: str, low: float, high: float) -> None:
        """Raise AssertionError unless every value of a column is within low … high."""
        for sample in self._samples:
            value = getattr(sample, column)
            assert low <= value <= high, (
                f'{column} is {value:g} at {sample.time:g} s, outside {low:g} to {high:g}')

    def assert_reaches(self, column: str, value: float, within: float) -> float:
        """
        Return when (s) a column was within `within` of a value for the first time.

        AssertionError, with how near it came, if it never was.
        """
        near = Sample(np.nan, np.nan, np.nan, np.nan), np.inf
        for sample in self._samples:
            error = abs(getattr(sample, column) - value)
            if error <= within:
                return sample.time
            near = min(near, (sample, error), key=lambda pair: pair[1])
        raise AssertionError(
            f'{column} never came within {within:g} of {value:g}: the nearest was '
            f'{getattr(near[0], column):g} at {near[0].time:g} s')

    def __getitem__(self, column: str) -> np.ndarray:
        """Return a column."""
        place = Sample._fields.index(column)
        return np.array([sample[place] for sample in self._samples])

    def __iter__(self) -> Iterator[Sample]:
        """Iterate over the samples."""
        return iter(self._samples)

    def __len__(self) -> int:
        """Return how many samples there are."""
        return len(self._samples)

    @property
    def last(self) -> Sample:
        """The last sample."""
        return self._samples[-1]
