# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Sizes that are sought in a valve, in proportion to those that are sought in the paper's.

Catalogue and terms say which sizes a record of the paper's positioner shows well, and how far to
search there. A valve of another size has other hysteresis, friction and leaks: a current is in
proportion to the range of the converter, a pressure to the supply, an area to the booster's
largest, a force to what the supply makes on the diaphragm, a length to the travel, the area of a
plug to that of the diaphragm, a controller's gain to range over travel. Shares, times, speeds and
thermal resistances stay as they are.
"""

from dataclasses import replace
import math

from .catalogue import Knob
from .gas import ATMOSPHERE
from .parameters import DESCRIPTIONS
from .system import PositionerParameters


PAPER = PositionerParameters()


def proportion(p: PositionerParameters, component: str, unit: str) -> float:
    """Return how many times as large sizes in this unit are in this valve as in the paper's."""
    ours, paper = _natural(p, component, unit), _natural(PAPER, component, unit)
    ratio = ours / paper
    return ratio if math.isfinite(ratio) and ratio > 0.0 else 1.0


def _natural(p: PositionerParameters, component: str, unit: str) -> float:
    """Return the valve's own size in this unit (SI), 1 for a unit that does not scale with it."""
    supply, area, travel = p.supply.pressure, p.booster.max_area, p.actuator.travel
    force = supply * (p.booster.s3 if component == 'booster' else p.actuator.effective_area)
    gain = p.ep_converter.gain
    sizes = {
        'A': supply / gain if gain else math.nan,
        'Pa': supply,
        'A/m': supply / gain / travel if gain and travel else math.nan,
        'm^2': area,
        'kg/s': area * (supply + ATMOSPHERE),
        'Pa s/kg': 1.0 / area if area else math.nan,
        'm^3': p.actuator.dead_volume,
        'm': travel,
        'N': force,
        'N/Pa': p.actuator.effective_area,
        'N/m': force / travel if travel else math.nan,
        'N s/m': force / travel if travel else math.nan,
    }
    return sizes.get(unit, 1.0)


def in_proportion(knob: Knob, p: PositionerParameters) -> Knob:
    """Return the knob with its sizes in proportion to this valve."""
    described = DESCRIPTIONS[knob.parameter]
    factor = proportion(
        p, knob.parameter.partition('.')[0], knob.goes_with or described.unit)
    if factor == 1.0:
        return knob
    low, high = (min(max(factor * end, described.low), described.high)
                 for end in (knob.low, knob.high))
    neutral = factor * knob.neutral if knob.shape else knob.neutral
    return replace(knob, typical=factor * knob.typical, low=low, high=high, neutral=neutral,
                   tried=tuple(factor * value for value in knob.tried))
