# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Air through an orifice.

Pressures in this file are absolute, because mass flow depends on them.
"""

import math

GAS_CONSTANT = 287.0
"""Specific gas constant of air, J/(kg K)."""

HEAT_RATIO = 1.4
"""Ratio of the specific heats of air (the paper's k; renamed, since k is also the opening gain)."""

ATMOSPHERE = 101_325.0
"""Absolute pressure that gauge pressures are counted from, Pa."""

ISENTROPIC_CRITICAL_RATIO = (2.0 / (HEAT_RATIO + 1.0)) ** (HEAT_RATIO / (HEAT_RATIO - 1.0))
"""Critical pressure ratio of an ideal nozzle, 0.5283 (paper eq. 3)."""

CHOKED_FLOW_FACTOR = math.sqrt(
    HEAT_RATIO / GAS_CONSTANT
    * (2.0 / (HEAT_RATIO + 1.0)) ** ((HEAT_RATIO + 1.0) / (HEAT_RATIO - 1.0))
)
"""K_G of paper eq. 6 with the exponent put right, 0.0404 sqrt(kg K/J)."""

ISO_6358 = 0
ISENTROPIC = 1

_NEAR_EQUAL = 0.999


def iso_6358_flow_function(ratio: float, critical_ratio: float) -> float:
    """
    Return the flow relative to choked flow, the ellipse of ISO 6358 (paper eq. 7).

    >>> iso_6358_flow_function(0.4, 0.5283)
    1.0
    """
    if ratio <= critical_ratio:
        return 1.0
    distance = (ratio - critical_ratio) / (1.0 - critical_ratio)
    return math.sqrt(max(0.0, 1.0 - distance * distance))


def isentropic_flow_function(ratio: float) -> float:
    """
    Return the flow relative to choked flow, exact isentropic nozzle (paper eq. 2).

    >>> round(isentropic_flow_function(0.8), 3)
    0.819
    """
    if ratio <= ISENTROPIC_CRITICAL_RATIO:
        return 1.0
    energy = ratio ** (2.0 / HEAT_RATIO) - ratio ** ((HEAT_RATIO + 1.0) / HEAT_RATIO)
    return math.sqrt(max(0.0, 2.0 / (HEAT_RATIO - 1.0) / GAS_CONSTANT * HEAT_RATIO * energy)) / (
        CHOKED_FLOW_FACTOR
    )


def flow_function(ratio: float, critical_ratio: float, law: int) -> float:
    """
    Return the flow relative to choked flow for a pressure ratio in 0..1, either law.

    Both laws have an infinite slope at ratio 1. From 0.999 on they are continued by the odd cubic
    that joins them with the slope of a square root, so that the flow reverses smoothly.
    """
    if ratio > _NEAR_EQUAL:
        s = (1.0 - ratio) / (1.0 - _NEAR_EQUAL)
        return _law(_NEAR_EQUAL, critical_ratio, law) * s * (1.25 - 0.25 * s * s)
    return _law(ratio, critical_ratio, law)


def _law(ratio: float, critical_ratio: float, law: int) -> float:
    if law == ISENTROPIC:
        return isentropic_flow_function(ratio)
    return iso_6358_flow_function(ratio, critical_ratio)


def orifice_flow(
    area: float,
    pressure_1: float,
    pressure_2: float,
    temperature_1: float,
    temperature_2: float,
    critical_ratio: float,
    law: int,
) -> float:
    """
    Return the mass flow from side 1 to side 2, kg/s, negative when side 2 is higher (paper eq. 5).

    `area` is the effective area in m², pressures are absolute in Pa, temperatures in K; the
    temperature that counts is the upstream one.
    """
    if area <= 0.0:
        return 0.0
    if pressure_1 >= pressure_2:
        psi = flow_function(pressure_2 / pressure_1, critical_ratio, law)
        return CHOKED_FLOW_FACTOR * area * pressure_1 / math.sqrt(temperature_1) * psi
    psi = flow_function(pressure_1 / pressure_2, critical_ratio, law)
    return -CHOKED_FLOW_FACTOR * area * pressure_2 / math.sqrt(temperature_2) * psi


def enthalpy_flow(flow: float, temperature_1: float, temperature_2: float) -> float:
    """
    Return q T of a mass flow (kg/s) from side 1 to side 2, K kg/s: it is as warm as its source.

    >>> enthalpy_flow(0.001, 300.0, 400.0), enthalpy_flow(-0.001, 300.0, 400.0)
    (0.3, -0.4)
    """
    return flow * (temperature_1 if flow > 0.0 else temperature_2)
