# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tubing between the booster's outlet and the actuator."""

from typing import Annotated, NamedTuple

from .gas import ATMOSPHERE, GAS_CONSTANT, ISO_6358, orifice_flow
from .quantity import Quantity


class Tubing(NamedTuple):
    """A volume at the booster's outlet and a restriction behind it."""

    restriction_area: Annotated[float, Quantity(
        'm^2', 'tubing_restriction: effective area of tube and fittings, 0 = none',
        0.0, 1.0)] = 0.0
    outlet_volume: Annotated[float, Quantity(
        'm^3', 'tubing_restriction: volume between booster and restriction', 1e-7, 1e-2,
        'a short tube: 10 to 50 mL')] = 4e-5
    critical_pressure_ratio: Annotated[float, Quantity(
        '-', 'tubing_restriction: critical pressure ratio of the tube', 0.0, 0.95,
        'as the booster')] = 0.5283


def tube_flow(
    tubing: Tubing, outlet: float, chamber: float, outlet_temperature: float,
    chamber_temperature: float,
) -> float:
    """Return the mass flow outlet → chamber, kg/s, from gauge pressures in Pa."""
    return orifice_flow(
        tubing.restriction_area, outlet + ATMOSPHERE, chamber + ATMOSPHERE,
        outlet_temperature, chamber_temperature, tubing.critical_pressure_ratio, ISO_6358,
    )


def outlet_pressure_rate(
    tubing: Tubing, inflow: float, outflow: float, temperature: float
) -> float:
    """Return d(outlet pressure)/dt, Pa/s (isothermal, the volume is small)."""
    return GAS_CONSTANT * temperature * (inflow - outflow) / tubing.outlet_volume
