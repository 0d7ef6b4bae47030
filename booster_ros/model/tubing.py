# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tubing between the booster's outlet and the actuator."""

import math
from typing import Annotated, NamedTuple

from .gas import ATMOSPHERE, CHOKED_FLOW_FACTOR, GAS_CONSTANT, ISO_6358, orifice_flow
from .quantity import Quantity

LAMINAR_PRESSURE = 1e5
"""Pressure, Pa, by which an effective area becomes the conductance of laminar flow: with it an
orifice and a laminar tube of the same area carry about the same where a tenth of 300 kPa is lost.
"""


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
    laminar_share: Annotated[float, Quantity(
        '-', 'tubing_restriction: how laminar the flow is, from 0, an orifice, to 1, a long thin '
        'tube', 0.0, 1.0)] = 0.0


def tube_flow(
    tubing: Tubing, outlet: float, chamber: float, outlet_temperature: float,
    chamber_temperature: float,
) -> float:
    """
    Return the mass flow outlet → chamber, kg/s, from gauge pressures in Pa.

    Parts of the drop that go with q and with q² add up (P. Forchheimer, Z. VDI 45 (1901) 1781):
    s q/q_l + (1 - s) (q/q_o)² = 1, with the laminar share s, the flow q_l of a laminar tube, in
    proportion to the difference of the squared absolute pressures (Hagen-Poiseuille, isothermal),
    and the flow q_o of an orifice (ISO 6358-1).
    """
    turbulent = orifice_flow(
        tubing.restriction_area, outlet + ATMOSPHERE, chamber + ATMOSPHERE,
        outlet_temperature, chamber_temperature, tubing.critical_pressure_ratio, ISO_6358,
    )
    share = tubing.laminar_share
    if share == 0.0 or turbulent == 0.0:
        return turbulent
    temperature = outlet_temperature if outlet > chamber else chamber_temperature
    laminar = CHOKED_FLOW_FACTOR * tubing.restriction_area / math.sqrt(temperature) * (
        outlet - chamber) * (outlet + chamber + 2.0 * ATMOSPHERE) / LAMINAR_PRESSURE
    straight = share / abs(laminar)
    squared = (1.0 - share) / (turbulent * turbulent)
    flow = 2.0 / (straight + math.sqrt(straight * straight + 4.0 * squared))
    return math.copysign(flow, laminar)


def outlet_pressure_rate(
    tubing: Tubing, inflow: float, outflow: float, temperature: float
) -> float:
    """Return d(outlet pressure)/dt, Pa/s (isothermal, the volume is small)."""
    return GAS_CONSTANT * temperature * (inflow - outflow) / tubing.outlet_volume
