# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Chamber of the actuator: its volume, what leaks from it, how its pressure changes."""

from .actuator import Actuator
from .gas import (
    ATMOSPHERE, GAS_CONSTANT, HEAT_RATIO, ISENTROPIC_CRITICAL_RATIO, ISO_6358, orifice_flow)


def chamber_volume(act: Actuator, position: float) -> float:
    """Return V(x) = V0 + integral of A, m³."""
    swept = act.effective_area * position * (1.0 - 0.5 * act.area_change * position / act.travel)
    return act.dead_volume + act.added_volume + swept


def leak_flow(act: Actuator, pressure: float, temperature: float, ambient: float,
              discrepancy: float) -> float:
    """Return the mass flow chamber → atmosphere past the booster, kg/s (pressure gauge, Pa)."""
    return discrepancy + orifice_flow(
        act.leak_area, pressure + ATMOSPHERE, ATMOSPHERE, temperature, ambient,
        ISENTROPIC_CRITICAL_RATIO, ISO_6358)


def isothermal_pressure_rate(
    act: Actuator, pressure: float, volume: float, swept: float, compliance: float, inflow: float,
    temperature: float,
) -> float:
    """
    Return dp/dt = n (R T q - P A v) / (V + n P C), Pa/s.

    `pressure` gauge Pa, `swept` the volume A v that the stem opens in m³/s, `compliance` C = dV/dp
    in m³/Pa, `inflow` the net mass flow in kg/s. n = 1 is isothermal, else polytropic.
    """
    index, absolute = act.polytropic_index, pressure + ATMOSPHERE
    return index * (GAS_CONSTANT * temperature * inflow - absolute * swept) / (
        volume + index * absolute * compliance)


def isothermal_filling(
    act: Actuator, pressure: float, volume: float, swept: float, compliance: float, rate: float,
    temperature: float,
) -> float:
    """
    Return the net mass flow, kg/s, with which the pressure changes by `rate`, Pa/s.

    The inverse of `isothermal_pressure_rate`.
    """
    index, absolute = act.polytropic_index, pressure + ATMOSPHERE
    return (rate * (volume + index * absolute * compliance) / index + absolute * swept) / (
        GAS_CONSTANT * temperature)


def energy_rates(
    act: Actuator, pressure: float, gas_temperature: float, volume: float, swept: float,
    compliance: float, enthalpy_flow: float, inflow: float, wall_temperature: float,
) -> tuple[float, float]:
    """
    Return (dp/dt in Pa/s, dT/dt in K/s) of the energy balance with heat through the wall.

    `swept` and `compliance` as in `isothermal_pressure_rate`; `enthalpy_flow` is the sum of q T of
    all streams, kg K/s; `inflow` the sum of q, kg/s.
    """
    absolute = pressure + ATMOSPHERE
    heat = (wall_temperature - gas_temperature) / act.thermal_resistance
    rate = (
        HEAT_RATIO * (GAS_CONSTANT * enthalpy_flow - absolute * swept)
        + (HEAT_RATIO - 1.0) * heat
    ) / (volume + HEAT_RATIO * absolute * compliance)
    volume_rate = swept + compliance * rate
    mass = absolute * volume / (GAS_CONSTANT * gas_temperature)
    return rate, gas_temperature * (rate / absolute + volume_rate / volume - inflow / mass)
