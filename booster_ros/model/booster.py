# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Booster (pneumatic amplifier): three diaphragms, an intake and an exhaust seat."""

from typing import Annotated, NamedTuple

from .gas import ATMOSPHERE, ISO_6358, orifice_flow
from .quantity import Quantity


THREE_DIAPHRAGMS, NO_BOOSTER = 0, 1


class Booster(NamedTuple):
    """Diaphragm areas and the two seats that their force opens."""

    s1: Annotated[float, Quantity(
        'm^2', 'effective area of the upper diaphragm', 1e-9, 1.0, 'paper section II.C')] = 13.52e-6
    s2: Annotated[float, Quantity(
        'm^2', 'effective area of the middle diaphragm', 1e-9, 1.0, 'paper section II.C')] = 9.28e-6
    s3: Annotated[float, Quantity(
        'm^2', 'effective area of the lower diaphragm', 1e-9, 1.0, 'paper section II.C')] = 3.14e-6
    opening_gain: Annotated[float, Quantity(
        'm^2/N', 'flow area opened per newton of force, k', 0.0, 1.0,
        'paper section III, 0.275e-11 m^2/(Pa mm^2)')] = 2.75e-6
    max_area: Annotated[float, Quantity(
        'm^2', 'largest flow area of a seat, Max', 0.0, 1.0, 'paper section III')] = 1.45e-6
    critical_pressure_ratio: Annotated[float, Quantity(
        '-', 'pressure ratio below which flow is choked, b', 0.0, 0.95, 'paper eq. 3')] = 0.5283
    orifice_law: Annotated[int, Quantity(
        '-', 'iso_6358 (ellipse) or isentropic (exact nozzle)', source='paper eq. 7')] = ISO_6358
    kind: Annotated[int, Quantity(
        '-', 'three_diaphragms, or none: what the converter gives goes into tube and chamber '
        'directly, and nothing else here counts', source='paper section II.A')] = THREE_DIAPHRAGMS
    critical_pressure_ratio_shift: Annotated[float, Quantity(
        '-', 'critical_pressure_ratio: what the seats differ from the declared ratio by',
        -0.9, 0.4)] = 0.0
    intake_preload: Annotated[float, Quantity(
        'N', 'booster_dead_band: force before the intake opens, F0', 0.0, 100.0)] = 0.0
    exhaust_preload: Annotated[float, Quantity(
        'N', 'booster_dead_band: force before the exhaust opens, F0', 0.0, 100.0)] = 0.0
    exhaust_gain_ratio: Annotated[float, Quantity(
        '-', 'exhaust_asymmetry: width of the exhaust seat relative to the intake, which scales '
        'its opening gain and its largest area', 1e-3, 1e3)] = 1.0
    exhaust_lift_ratio: Annotated[float, Quantity(
        '-', 'exhaust_asymmetry: largest lift of the exhaust relative to the intake, which scales '
        'its largest area', 1e-3, 1e3)] = 1.0
    intake_flow_force: Annotated[float, Quantity(
        '-', 'plug_flow_force: jet force on the intake plug per pressure drop and open area',
        0.0, 1e3)] = 0.0
    exhaust_flow_force: Annotated[float, Quantity(
        '-', 'plug_flow_force: jet force on the exhaust plug per pressure drop and open area',
        0.0, 1e3)] = 0.0
    opening_exponent: Annotated[float, Quantity(
        '-', 'opening_nonlinearity: exponent of the opening over the force', 0.1, 10.0)] = 1.0
    knee_softness: Annotated[float, Quantity(
        '-', 'opening_nonlinearity: 0 sharp knee at max_area, 1 very soft', 0.0, 1.0)] = 0.0
    supply_leak_area: Annotated[float, Quantity(
        'm^2', 'supply_seat_leak: intake seat that never closes', 0.0, 1e-3)] = 0.0
    exhaust_leak_area: Annotated[float, Quantity(
        'm^2', 'exhaust_seat_leak: exhaust seat that never closes', 0.0, 1e-3)] = 0.0


def diaphragm_force(
    booster: Booster, back_pressure: float, outlet: float, supply: float
) -> float:
    """Return F, N, from gauge pressures in Pa (paper section II.A): > 0 opens the intake."""
    return (
        back_pressure * booster.s1 - outlet * booster.s3 - supply * (booster.s2 - booster.s3)
    )


def opening_area(
    booster: Booster, force: float, gain: float, max_area: float, jet_stiffness: float
) -> float:
    """
    Return the area, m², that `force` (N, beyond the preload) opens: min(gain F, max_area).

    The jet pushes the plug back with `jet_stiffness` (N/m²) times the open area, so that
    F = S/gain + jet_stiffness S (flow force: J. F. Blackburn et al., Fluid Power Control, ch. 10).
    """
    if force <= 0.0 or max_area <= 0.0:
        return 0.0
    area = gain * force / (1.0 + gain * jet_stiffness)
    if booster.opening_exponent != 1.0:
        area = max_area * (area / max_area) ** booster.opening_exponent
    if booster.knee_softness > 0.0:
        p = 1.0 / booster.knee_softness
        if p < 60.0:
            share = min(area / max_area, 1e3)  # the power would overflow long beyond the knee
            return max_area * share / (1.0 + share**p) ** (1.0 / p)
    return min(area, max_area)


def intake_area(booster: Booster, force: float, supply: float, outlet: float) -> float:
    """Return the open area of the intake, m², with gauge pressures in Pa."""
    return opening_area(
        booster, force - booster.intake_preload, booster.opening_gain, booster.max_area,
        booster.intake_flow_force * max(supply - outlet, 0.0),
    )


def largest_exhaust_area(booster: Booster) -> float:
    """Return the area, m², at which the exhaust is fully open: width of the seat times lift."""
    return booster.max_area * booster.exhaust_gain_ratio * booster.exhaust_lift_ratio


def exhaust_area(booster: Booster, force: float, outlet: float) -> float:
    """Return the open area of the exhaust, m², with the gauge pressure of the outlet in Pa."""
    return opening_area(
        booster, -force - booster.exhaust_preload,
        booster.opening_gain * booster.exhaust_gain_ratio,
        largest_exhaust_area(booster),
        booster.exhaust_flow_force * max(outlet, 0.0),
    )


def intake_flow(
    booster: Booster, area: float, supply: float, outlet: float,
    supply_temperature: float, outlet_temperature: float,
) -> float:
    """Return the mass flow supply → outlet, kg/s, through the open area and the seat's leak."""
    return orifice_flow(
        area + booster.supply_leak_area, supply + ATMOSPHERE, outlet + ATMOSPHERE,
        supply_temperature, outlet_temperature,
        booster.critical_pressure_ratio + booster.critical_pressure_ratio_shift,
        booster.orifice_law,
    )


def exhaust_flow(booster: Booster, area: float, outlet: float, outlet_temperature: float,
                 ambient_temperature: float) -> float:
    """Return the mass flow outlet → atmosphere, kg/s, through the open area and the leak."""
    return orifice_flow(
        area + booster.exhaust_leak_area, outlet + ATMOSPHERE, ATMOSPHERE,
        outlet_temperature, ambient_temperature,
        booster.critical_pressure_ratio + booster.critical_pressure_ratio_shift,
        booster.orifice_law,
    )
