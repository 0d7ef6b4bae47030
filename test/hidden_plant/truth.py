# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What was put in, under the names that the model has for it.

Only where both mean the same: an effect that the model describes by another law has no true size
there, and with such an effect the declared parameters that fit best are not the true ones.
"""

from collections.abc import Mapping, Sequence

from .declared import SPREADS
from .plant import Valve

Key = tuple[str, int | None]  # a parameter and, in a list, its element

_FRICTION, _EXCESS = 'actuator.coulomb_friction', 'actuator.stiction'
_FADES = {'actuator.stribeck_velocity': 1e-3}

SIZES: Mapping[str, Mapping[str, float]] = {
    'ep_hysteresis': {'ep_converter.hysteresis': 1.0},
    'dead_time': {'ep_converter.dead_time': 1.0},
    'booster_dead_band': {'booster.intake_preload': 1.0, 'booster.exhaust_preload': 1.0},
    'supply_seat_leak': {'booster.supply_leak_area': 1.0},
    'exhaust_seat_leak': {'booster.exhaust_leak_area': 1.0},
    'supply_droop': {'supply.droop': 1.0},
    'chamber_leak': {'actuator.leak_area': 1.0},
    'heat_transfer': {'actuator.thermal_resistance': 1.0},
    'stem_friction': {_FRICTION: 1.0, _EXCESS: 0.35},
    'stem_friction_coulomb': {_FRICTION: 1.0},
    'stem_friction_stick_slip': {_FRICTION: 1.0, _EXCESS: 1.0},
    'stem_friction_yielding': {_FRICTION: 1.0, _EXCESS: 0.35},
    'position_dependent_friction': {_FRICTION: 0.2, 'actuator.friction_gradient': 1.5},
    'bench_set_shift': {'actuator.bench_set_shift': 1.0},
    'position_backlash': {'sensors.position_backlash': 1.0},
    'position_sensor_lag': {'sensors.position_lag': 1.0},
    'position_sensor_bias': {'sensors.position_bias': 1.0},
    'pressure_sensor_lag': {'sensors.pressure_lag': 1.0},
    'pressure_sensor_bias': {'sensors.pressure_bias': 1.0},
}
"""Per unit of the size, by key of EFFECTS."""

SHAPES: Mapping[str, Mapping[str, float]] = {
    'stem_friction': _FADES,
    'stem_friction_stick_slip': _FADES,
    'stem_friction_yielding': {
        **_FADES, 'actuator.presliding_stiffness': 3e7, 'actuator.presliding_damping': 0.3},
}
"""What does not go with the size."""


def declared_truth(valve: Valve) -> dict[Key, float]:
    """Return the true values of the declared parameters that a refit may move, SI units."""
    stem, area = valve.stem, valve.chamber.area
    low = stem.preload / area
    return {
        ('ep_converter.gain', None): valve.converter.gain,
        ('ep_converter.offset', None): valve.converter.offset,
        ('ep_converter.time_constant', None): valve.converter.time_constant,
        ('booster.opening_gain', None): valve.booster.opening_gain,
        ('booster.max_area', None): valve.booster.max_area,
        ('booster.critical_pressure_ratio', None): valve.booster.critical_ratio,
        ('supply.pressure', None): valve.supply.pressure,
        ('actuator.dead_volume', None): valve.chamber.dead_volume,
        ('actuator.bench_set', 0): low,
        ('actuator.bench_set', 1): low + stem.spring_rate * stem.travel / area,
        ('actuator.viscous_friction', None): stem.viscous_friction,
    }


def true_parameters(
    clean: Valve, effects: Sequence[tuple[str, float]], spread: str
) -> dict[str, float]:
    """
    Return all that is known, as reports name it: `actuator.bench_set[0]` for an element.

    `clean` is the valve without its effects, (key, size) in SI units. Nothing is known where the
    model has another law, or where the spread moves the diaphragm's area: a model cannot tell that
    from the volumes and openings, and takes the declared one.
    """
    if 'area' in SPREADS[spread] or not all(key in SIZES for key, _ in effects):
        return {}
    known = {name if element is None else f'{name}[{element}]': value
             for (name, element), value in declared_truth(clean).items()}
    for key, size in effects:
        known |= effect_truth(key, size)
    return known


def effect_truth(effect: str, size: float) -> dict[str, float]:
    """Return the model's parameters for an effect of a size; KeyError where it has none."""
    return {**{name: weight * size for name, weight in SIZES[effect].items()},
            **SHAPES.get(effect, {})}
