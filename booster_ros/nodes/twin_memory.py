# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When the memory of a twin is written, and what is said where that or reading it fails."""

from pathlib import Path
import time
from typing import TYPE_CHECKING

from rclpy.impl.rcutils_logger import RcutilsLogger

from ..model.parameters import ParameterError
from ..model.system import PositionerParameters
from ..twin.memory import Memory, RecallError, recall, save, set_aside
from ..twin.twin import Twin

if TYPE_CHECKING:
    from .twin_answers import Answers

SELDOM = 600.0
"""Seconds from one writing to the next once the valve has been learnt; until then each minute."""


class TwinMemory:
    """Reads the file `path` ('': there is none) at the start; ParameterError where it can't be."""

    def __init__(self, logger: RcutilsLogger, path: str, declared: PositionerParameters) -> None:
        self._logger, self._declared = logger, declared
        self._path = Path(path) if path else None
        self._written, self._blocks = time.monotonic(), -1
        self.recalled = self._recall()
        """What was there at the start."""
        if self._path is not None:
            self._try(self.recalled, at_start=True)

    def _recall(self) -> Memory:
        if self._path is None:
            return Memory()
        try:
            return recall(self._path, self._declared)
        except OSError as error:
            raise ParameterError(f'memory: {self._path}: {error.strerror}') from None
        except RecallError as error:
            try:
                there = set_aside(self._path)
            except OSError as problem:
                raise ParameterError(f'memory: {error}, and cannot be renamed: '
                                     f'{problem.strerror}') from None
            self._logger.warning(f'{error}; it is now {there}, and a new one is made')
            return Memory()

    def is_due(self, twin: Twin) -> bool:
        """Tell whether there is something new that it is time to write."""
        if self._path is None or twin.alarms is None or twin.alarms.seen == self._blocks:
            return False
        return not twin.alarms.promised or time.monotonic() - self._written >= SELDOM

    def save(self, twin: Twin, answers: 'Answers') -> None:
        """Write the file anew."""
        if self._path is None:
            return
        self._written = time.monotonic()
        self._blocks = -1 if twin.alarms is None else twin.alarms.seen
        # a twin that has not run yet knows no more than what it recalled
        calibration = twin.calibration() or self.recalled.calibration
        self._try(Memory(answers.adopted, calibration, answers.verdict, answers.on_trial))

    def _try(self, memory: Memory, at_start: bool = False) -> None:
        assert self._path is not None
        try:
            save(self._path, self._declared, memory)
        except OSError as error:
            if at_start:
                raise ParameterError(
                    f'memory: {self._path} cannot be written: {error.strerror}') from None
            self._logger.error(f'{self._path} cannot be written: {error.strerror}; what is learnt '
                               'is lost at a restart', throttle_duration_sec=600.0)
