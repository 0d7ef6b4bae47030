# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actuator chamber and the line that feeds it: volumes, diaphragm area, leaks, heat."""

from typing import NamedTuple

from numba import njit

from .gas import ATMOSPHERE, GAS_CONSTANT, HEAT_CAPACITY, mass_flow


class Line(NamedTuple):
    """Tubing between booster and chamber; absent while its resistances are 0."""

    resistance: float = 0.0  # 1/m², inverse of the line's equivalent area
    volume: float = 2e-5  # m³, at the booster's end
    laminar_resistance: float = 0.0  # Pa² s/kg, of a sintered filter in place of an orifice


class Chamber(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    area: float = 0.0796  # m², effective, at zero travel
    dead_volume: float = 0.185e-3  # m³
    travel: float = 0.016  # m, the length that area_change refers to

    area_change: float = 0.0  # relative change of effective area over the travel
    bulge: float = 0.0  # m³, dead volume that opens as the stem passes bulge_position
    bulge_position: float = 0.005  # m
    bulge_length: float = 0.002  # m
    leak: float = 0.0  # m²
    travel_leak: float = 0.0  # m², leak at full travel, none when shut
    relief_leak: float = 0.0  # m² per 100 kPa above relief_pressure
    relief_pressure: float = 190e3  # Pa gauge
    late_leak: float = 0.0  # m², leak that opens at late_leak_time
    late_leak_time: float = 20.0  # s
    wall_resistance: float = 0.0  # K/W between gas and wall; 0 keeps the gas at wall temperature


@njit(cache=True)
def line_flow(line, outlet, outlet_temperature, pressure, temperature, critical_ratio):
    """Return the flow in kg/s from the booster's end into the chamber; pressures are absolute."""
    if line.laminar_resistance > 0.0:
        return (outlet * outlet - pressure * pressure) / line.laminar_resistance
    return mass_flow(
        1.0 / line.resistance, outlet, outlet_temperature, pressure, temperature, critical_ratio
    )


@njit(cache=True)
def diaphragm_area(chamber, position):
    """Return the effective area in m²."""
    return chamber.area * (1.0 + chamber.area_change * position / chamber.travel)


@njit(cache=True)
def gas_volume(chamber, position):
    """Return the volume in m³: dead volume and what the diaphragm has swept."""
    swept = chamber.area * position * (1.0 + 0.5 * chamber.area_change * position / chamber.travel)
    share = (position - chamber.bulge_position) / chamber.bulge_length
    share = min(max(share, 0.0), 1.0)
    smooth_share = share * share * (3.0 - 2.0 * share)
    return chamber.dead_volume + swept + chamber.bulge * smooth_share


@njit(cache=True)
def leak_area(chamber, pressure, position, time):
    """Return the area in m² of all leaks at a gauge pressure, travel and time (s)."""
    area = chamber.leak
    if time >= chamber.late_leak_time:
        area += chamber.late_leak
    area += chamber.travel_leak * min(max(position / chamber.travel, 0.0), 1.0)
    area += chamber.relief_leak * max(pressure - chamber.relief_pressure, 0.0) / 1e5
    return area


@njit(cache=True)
def absolute_pressure(mass, temperature, volume):
    """Return the pressure in Pa of an ideal gas."""
    return mass * GAS_CONSTANT * temperature / volume


@njit(cache=True)
def warming(chamber, mass, temperature, wall, inflow, inflow_temperature, outflow, work_rate):
    """
    Return dT/dt in K/s of the chamber's gas from the first law, work_rate being P dV/dt in W.

    m c_v dT/dt = q_in (c_p T_in − c_v T) − q_out R T − P dV/dt + (T_wall − T)/resistance
    """
    enthalpy = (HEAT_CAPACITY + GAS_CONSTANT) * inflow_temperature
    power = (
        inflow * (enthalpy - HEAT_CAPACITY * temperature)
        - outflow * GAS_CONSTANT * temperature
        - work_rate
        + (wall - temperature) / chamber.wall_resistance
    )
    return power / (mass * HEAT_CAPACITY)


@njit(cache=True)
def ambient_mass(volume, temperature):
    """Return the mass in kg of a volume at atmospheric pressure."""
    return ATMOSPHERE * volume / (GAS_CONSTANT * temperature)
