# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Air: the constants and the flow through an orifice. Pressures here are absolute."""

import math

from numba import njit

ATMOSPHERE = 101_325.0  # Pa
GAS_CONSTANT = 287.05  # J/(kg K), dry air
HEAT_RATIO = 1.4
HEAT_CAPACITY = GAS_CONSTANT / (HEAT_RATIO - 1.0)  # J/(kg K), at constant volume
CHOKED_FLOW = math.sqrt(
    HEAT_RATIO
    / GAS_CONSTANT
    * (2.0 / (HEAT_RATIO + 1.0)) ** ((HEAT_RATIO + 1.0) / (HEAT_RATIO - 1.0))
)
# Above this pressure ratio the ellipse, whose slope is infinite at 1, is continued by a chord.
LAMINAR_RATIO = 0.999


@njit(cache=True)
def flow_function(ratio, critical_ratio):
    """Return ψ(P2/P1) of ISO 6358, 1 when choked and 0 at equal pressures."""
    if ratio <= critical_ratio:
        return 1.0
    if ratio >= 1.0:
        return 0.0
    subsonic = (min(ratio, LAMINAR_RATIO) - critical_ratio) / (1.0 - critical_ratio)
    value = math.sqrt(1.0 - subsonic * subsonic)
    if ratio > LAMINAR_RATIO:
        value *= (1.0 - ratio) / (1.0 - LAMINAR_RATIO)
    return value


@njit(cache=True)
def mass_flow(
    area, upstream, upstream_temperature, downstream, downstream_temperature, critical_ratio
):
    """Return the flow in kg/s from upstream to downstream, negative when it runs backwards."""
    if area <= 0.0:
        return 0.0
    if upstream >= downstream:
        density = upstream / math.sqrt(upstream_temperature)
        return area * CHOKED_FLOW * density * flow_function(downstream / upstream, critical_ratio)
    density = downstream / math.sqrt(downstream_temperature)
    return -area * CHOKED_FLOW * density * flow_function(upstream / downstream, critical_ratio)
