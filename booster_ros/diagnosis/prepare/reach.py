# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Channels that go where the declared valve cannot: said before a search, as it will not help."""

from collections.abc import Mapping

import numpy as np

from booster_ros.model.system import PositionerParameters

Array = np.ndarray

MOST = 0.99
BEYOND_SUPPLY, BEYOND_TRAVEL = 1.05, 0.05
"""Quantile of the values that counts as reached, multiple of the supply, and share of the travel
beyond either end, from which a channel is out of reach."""


def out_of_reach(
    columns: Mapping[str, Array], declared: PositionerParameters
) -> tuple[str, ...]:
    """Return a sentence for each channel, SI units, that reaches what the declared valve cannot."""
    notes = []
    supply = declared.supply.pressure
    for name in ('chamber_pressure', 'back_pressure'):
        values = columns.get(name, np.empty(0))
        values = values[np.isfinite(values)]
        if values.size and 0.0 < BEYOND_SUPPLY * supply < float(np.quantile(values, MOST)):
            notes.append(f'{name} reaches {np.quantile(values, MOST):.4g} Pa, above the declared '
                         f'supply of {supply:.4g} Pa: the declared valve cannot')
    position = columns.get('valve_position', np.empty(0))
    position = position[np.isfinite(position)]
    travel = declared.actuator.travel
    if position.size:
        low, high = np.quantile(position, [1.0 - MOST, MOST])
        if high > (1.0 + BEYOND_TRAVEL) * travel or low < -BEYOND_TRAVEL * travel:
            notes.append(f'valve_position goes from {low:.4g} to {high:.4g} m, beyond the declared '
                         f'travel of 0 to {travel:.4g} m: the declared valve cannot')
    return tuple(notes)
