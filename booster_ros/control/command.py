# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What current to send: the profile itself, or what makes the stem follow the profile."""

from typing import Protocol

from booster_ros.control.pi import PiController
from booster_ros.control.profiles import Profile
from booster_ros.control.settings import POSITION, ControllerSettings


class Command(Protocol):
    """Decides on the current to send."""

    set_point: float
    """Where the profile was at the last call, A or m."""

    def current(self, time: float, position: float) -> float:
        """Return the current (A) at a time (s) since the start, the stem being at `position` m."""


class OpenLoop:
    """Sends the profile."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self.set_point = profile.value(0.0)

    def current(self, time: float, position: float) -> float:
        """Return the current (A) at a time (s) since the start."""
        self.set_point = self._profile.value(time)
        return self.set_point


class PositionLoop:
    """Makes the stem follow the profile."""

    def __init__(self, profile: Profile, controller: PiController) -> None:
        self._profile = profile
        self._controller = controller
        self._last_time = 0.0
        self.set_point = profile.value(0.0)

    def current(self, time: float, position: float) -> float:
        """Return the current (A) at a time (s) since the start, the stem being at `position` m."""
        self.set_point = self._profile.value(time)
        elapsed = time - self._last_time
        self._last_time = time
        return self._controller.update(self.set_point - position, elapsed)


def make_command(settings: ControllerSettings, profile: Profile) -> Command:
    """Return the command that the settings ask for."""
    if settings.mode != POSITION:
        return OpenLoop(profile)
    low, high = settings.loop_current_limits
    return PositionLoop(profile, PiController(
        settings.loop_gain, settings.loop_integral_time, low, high, settings.loop_bias))
