# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a physical parameter is: unit, meaning, range and source, kept beside its value."""

from dataclasses import dataclass
import math


@dataclass(frozen=True)
class Quantity:
    """
    The description of one parameter, attached to the field that holds it.

    `low` and `high` are the physical limits, both allowed. `source` says where the default is from.
    """

    unit: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    source: str = 'neutral: no effect'
