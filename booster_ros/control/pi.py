# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The position loop of a valve positioner: a discrete PI controller that does not wind up."""

from dataclasses import dataclass


@dataclass
class PiController:
    """
    u = gain · (error + ∫ error dt / integral_time), limited to low … high.

    `gain` is A/m, `integral_time` s, the limits A. The integral stands still while the output is
    at a limit and the error pushes further (conditional integration).
    """

    gain: float
    integral_time: float
    low: float
    high: float
    integral: float = 0.0
    """The integral part of the output, A; at the start the current to begin with."""

    def update(self, error: float, elapsed: float) -> float:
        """Return the current (A) for an error (m), `elapsed` seconds after the last update."""
        proportional = self.gain * error
        increment = proportional * elapsed / self.integral_time
        wanted = proportional + self.integral + increment
        pushes_further = (wanted > self.high and increment > 0.0) or (
            wanted < self.low and increment < 0.0
        )
        if not pushes_further:
            self.integral += increment
        return min(max(proportional + self.integral, self.low), self.high)
