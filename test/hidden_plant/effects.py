# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What the hidden plant can have that the declared model has not.

An effect adds `weight × size` to fields of the plant. Its three sizes are chosen by what the record
shows: the residual against the same plant without the effect, in the channel that shows it better,
is 2 (small), 10 (medium) and 36 (large) times the noise in the median over all. Effects that look
like a declared parameter being off (preload, dead volume, exhaust) are larger, to exceed
tolerances; what such a refit leaves of the small ones is below the noise all the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from .plant import Valve
from .sensors import Sensors

SIZES = ('small', 'medium', 'large')


@dataclass(frozen=True)
class Effect:
    """One effect: fields named `part.field`, the sizes in SI units, what a diagnosis should say."""

    location: str
    names: tuple[str, ...]  # all that are right
    weights: Mapping[str, float]
    sizes: tuple[float, float, float]
    fixed: Mapping[str, float] = field(default_factory=dict)
    signed: bool = False  # the other sign is physical too

    def size(self, name: str) -> float:
        """Return the size called small, medium or large."""
        return self.sizes[SIZES.index(name)]


def put_in(effect: Effect, size: float, valve: Valve, sensors: Sensors) -> tuple[Valve, Sensors]:
    """Return plant and sensors with the effect at a size."""
    parts = {**valve._asdict(), 'sensors': sensors}
    for path, weight in effect.weights.items():
        part, name = path.split('.')
        value = getattr(parts[part], name) + weight * size
        parts[part] = parts[part]._replace(**{name: value})
    for path, value in effect.fixed.items():
        part, name = path.split('.')
        parts[part] = parts[part]._replace(**{name: value})
    sensors = parts.pop('sensors')
    return Valve(**parts), sensors


AREA = Valve().chamber.area
# Two laws bend the settled line of position over pressure alike; only volumes tell them apart.
BENT_SPRING = ('spring_nonlinearity', 'effective_area_change')
# Without a line between them, air lost at the exhaust seat and from the chamber is the same air.
LOST_AIR = ('chamber_leak', 'exhaust_seat_leak')

CATALOGUED: dict[str, Effect] = {
    # current to back pressure
    'ep_hysteresis': Effect(
        'ep_converter', ('ep_hysteresis',), {'converter.hysteresis': 1.0}, (2e-7, 1e-6, 4e-6)
    ),
    'ep_drift': Effect(
        'ep_converter', ('ep_drift',), {'converter.drift': 1.0}, (1.2, 5.0, 20.0), signed=True
    ),
    'ep_drift_warm_up': Effect(
        'ep_converter',
        ('ep_drift',),
        {'converter.warm_up': 1.0},
        (80.0, 300.0, 1200.0),
        signed=True,
    ),
    'ep_nonlinearity': Effect(
        'ep_converter', ('ep_nonlinearity',), {'converter.compression': 1.0}, (5e-6, 1e-5, 2e-5)
    ),
    'ep_nonlinearity_bow': Effect(
        'ep_converter',
        ('ep_nonlinearity',),
        {'converter.bow': 1.0},
        (120.0, 450.0, 1800.0),
        signed=True,
    ),
    'dead_time': Effect(
        'ep_converter', ('dead_time',), {'converter.dead_time': 1.0}, (0.01, 0.04, 0.16)
    ),
    # booster
    'booster_dead_band': Effect(
        'booster',
        ('booster_dead_band',),
        {'booster.intake_preload': 1.0, 'booster.exhaust_preload': 1.0},
        (1e-3, 5e-3, 2e-2),
    ),
    'booster_dead_band_exhaust': Effect(
        'booster', ('booster_dead_band',), {'booster.exhaust_preload': 1.0}, (1e-3, 4e-3, 2e-2)
    ),
    'exhaust_asymmetry': Effect(
        'booster', ('exhaust_asymmetry',), {'booster.exhaust_change': 1.0}, (0.02, 0.1, 0.4)
    ),
    'exhaust_asymmetry_narrow': Effect(
        'booster', ('exhaust_asymmetry',), {'booster.exhaust_change': -1.0}, (0.02, 0.1, 0.35)
    ),
    'supply_seat_leak': Effect(
        'booster', ('supply_seat_leak',), {'booster.supply_leak': 1.0}, (1e-9, 5e-9, 3e-8)
    ),
    'exhaust_seat_leak': Effect(
        'booster', LOST_AIR[::-1], {'booster.exhaust_leak': 1.0}, (2e-9, 1e-8, 4e-8)
    ),
    'opening_nonlinearity': Effect(
        'booster',
        ('opening_nonlinearity',),
        {'booster.curvature': 1.0},
        (0.01, 0.04, 0.15),
        signed=True,
    ),
    'plug_flow_force': Effect(
        'booster', ('plug_flow_force',), {'booster.jet': 1.0}, (0.03, 0.12, 0.4)
    ),
    'critical_pressure_ratio': Effect(
        'booster', ('critical_pressure_ratio',), {'booster.critical_ratio': -1.0}, (0.08, 0.16, 0.3)
    ),
    # supply
    'supply_droop': Effect('supply', ('supply_droop',), {'supply.droop': 1.0}, (1e6, 4e6, 1.5e7)),
    'supply_ripple': Effect(
        'supply', ('supply_ripple',), {'supply.ripple': 1.0}, (500.0, 2e3, 8e3)
    ),
    'supply_ripple_slow': Effect(
        'supply',
        ('supply_ripple',),
        {'supply.ripple': 1.0},
        (200.0, 1e3, 4e3),
        fixed={'supply.ripple_frequency': 0.07},
    ),
    # line and chamber
    'tubing_restriction': Effect(
        'tubing', ('tubing_restriction',), {'line.resistance': 1.0}, (5e4, 2e5, 5e5)
    ),
    'chamber_leak': Effect('chamber', LOST_AIR, {'chamber.leak': 1.0}, (2e-9, 1e-8, 5e-8)),
    'heat_transfer': Effect(
        'chamber', ('heat_transfer',), {'chamber.wall_resistance': 1.0}, (0.1, 0.6, 5.0)
    ),
    'dead_volume_change': Effect(
        'chamber', ('dead_volume_change',), {'chamber.dead_volume': 1.0}, (4e-5, 8e-5, 2e-4)
    ),
    # stem
    'stem_friction': Effect(
        'stem',
        ('stem_friction',),
        {'stem.coulomb': 1.0},
        (15.0, 80.0, 350.0),
        fixed={'stem.stiction': 0.35},
    ),
    'stem_friction_coulomb': Effect(
        'stem', ('stem_friction',), {'stem.coulomb': 1.0}, (15.0, 80.0, 350.0)
    ),
    'stem_friction_stick_slip': Effect(
        'stem',
        ('stem_friction',),
        {'stem.coulomb': 1.0},
        (15.0, 80.0, 350.0),
        fixed={'stem.stiction': 1.0},
    ),
    'position_dependent_friction': Effect(
        'stem',
        ('position_dependent_friction',),
        {'stem.coulomb': 0.2, 'stem.coulomb_rise': 1.5},
        (20.0, 100.0, 450.0),
    ),
    'spring_nonlinearity': Effect(
        'stem', BENT_SPRING, {'stem.hardening': 1.0}, (0.005, 0.02, 0.08), signed=True
    ),
    'effective_area_change': Effect(
        'stem', BENT_SPRING[::-1], {'chamber.area_change': -1.0}, (0.002, 0.01, 0.04)
    ),
    'bench_set_shift': Effect(
        'stem', ('bench_set_shift',), {'stem.shift': AREA}, (1.5e3, 4e3, 1e4), signed=True
    ),
    'seat_load': Effect('stem', ('seat_load',), {'stem.seat_softness': 1.0}, (1e-8, 3e-8, 1.2e-7)),
    'flow_force': Effect('stem', ('flow_force',), {'stem.flow_force': 1.0}, (40.0, 200.0, 800.0)),
    # sensors
    'position_backlash': Effect(
        'sensor', ('position_backlash',), {'sensors.position_backlash': 1.0}, (4e-5, 1.3e-4, 5e-4)
    ),
    'position_sensor_lag': Effect(
        'sensor', ('position_sensor_lag',), {'sensors.position_lag': 1.0}, (0.01, 0.05, 0.2)
    ),
    'position_sensor_bias': Effect(
        'sensor',
        ('position_sensor_bias',),
        {'sensors.position_bias': 1.0},
        (2e-5, 8e-5, 3e-4),
        signed=True,
    ),
    'pressure_sensor_lag': Effect(
        'sensor', ('pressure_sensor_lag',), {'sensors.pressure_lag': 1.0}, (0.01, 0.05, 0.2)
    ),
    'pressure_sensor_bias': Effect(
        'sensor',
        ('pressure_sensor_bias',),
        {'sensors.pressure_bias': 1.0},
        (400.0, 1500.0, 5e3),
        signed=True,
    ),
}

UNCATALOGUED: dict[str, Effect] = {
    'ambient_gain_swing': Effect(
        'ep_converter',
        ('unknown', 'ep_drift'),
        {'converter.ambient_swing': 1.0},
        (3e-4, 1.5e-3, 5e-3),
    ),
    'converter_creep': Effect(
        'ep_converter', ('unknown',), {'converter.creep': 1.0}, (0.004, 0.016, 0.06)
    ),
    'spool_power_law': Effect(
        'booster',
        ('unknown', 'opening_nonlinearity'),
        {'booster.curvature': 1.0},
        (0.03, 0.15, 0.5),
    ),
    'spool_holes': Effect(
        'booster', ('unknown', 'opening_nonlinearity'), {'booster.ripple': 1.0}, (0.1, 0.3, 0.9)
    ),
    'sticking_relay': Effect(
        'booster', ('unknown',), {'booster.stick_force': 1.0}, (4e-3, 1.5e-2, 6e-2)
    ),
    'compressor_cycle': Effect(
        'supply', ('unknown', 'supply_ripple'), {'supply.sag': 1.0}, (200.0, 800.0, 3500.0)
    ),
    'leak_opens_with_travel': Effect(
        'chamber', ('unknown', 'chamber_leak'), {'chamber.travel_leak': 1.0}, (4e-9, 2e-8, 1e-7)
    ),
    'leak_above_pressure': Effect(
        'chamber', ('unknown', 'chamber_leak'), {'chamber.relief_leak': 1.0}, (5e-9, 3e-8, 1e-7)
    ),
    'bulging_diaphragm': Effect(
        'chamber', ('unknown', 'dead_volume_change'), {'chamber.bulge': 1.0}, (6e-6, 2.5e-5, 1e-4)
    ),
    'spring_knee': Effect(
        'stem', ('unknown', *BENT_SPRING), {'stem.knee': 1.0}, (0.01, 0.05, 0.2), signed=True
    ),
    'spring_creep': Effect('stem', ('unknown',), {'stem.creep': 1.0}, (0.01, 0.03, 0.12)),
    'pressure_drag': Effect(
        'stem',
        ('unknown', 'stem_friction', 'position_dependent_friction'),
        {'stem.drag': 1.0},
        (1e-4, 5e-4, 2e-3),
    ),
    'seat_jam': Effect(
        'stem', ('unknown', 'seat_load'), {'stem.seat_jam': 1.0}, (600.0, 2000.0, 5000.0)
    ),
    'late_pressure_clock': Effect(
        'sensor',
        ('unknown', 'pressure_sensor_lag'),
        {'sensors.pressure_lateness': 1.0},
        (0.01, 0.05, 0.2),
    ),
}

# apart, and last: what is drawn for the others goes with how many there are and with their places
VARIANTS: dict[str, Effect] = {
    'stem_friction_yielding': Effect(
        'stem',
        ('stem_friction',),
        {'stem.coulomb': 1.0},
        (15.0, 80.0, 350.0),
        fixed={'stem.stiction': 0.35, 'stem.packing_stiffness': 3e7},
    ),
    'stem_friction_one_sided': Effect(
        'stem',
        ('stem_friction',),
        {'stem.coulomb': 1.0, 'stem.one_sided': 0.5},
        (15.0, 80.0, 350.0),
    ),
}

FURTHER: dict[str, Effect] = {
    'relay_friction': Effect(
        'booster', ('unknown',), {'booster.relay_friction': 1.0}, (1e-3, 5e-3, 2e-2)
    ),
    'slow_venting': Effect(
        'ep_converter', ('unknown',), {'converter.slow_venting': 1.0}, (0.5, 2.5, 10.0)
    ),
    'position_arm': Effect(
        'sensor',
        ('unknown', 'position_sensor_bias'),
        {'sensors.position_arm': 1.0},
        (2.5e-5, 1.2e-4, 4.5e-4),
    ),
}

# of a valve that changes while it is recorded
CHANGES: dict[str, Effect] = {
    'late_leak': Effect(
        'chamber', LOST_AIR, {'chamber.late_leak': 1.0}, (2e-9, 1e-8, 5e-8)
    ),
    'supply_falls': Effect('supply', ('unknown',), {'supply.fall': 1.0}, (1e3, 4e3, 1.2e4)),
}

# last of all, as the draws of the changes go with their places, too
LATER_VARIANTS: dict[str, Effect] = {
    'tubing_laminar': Effect(
        'tubing', ('tubing_restriction',), {'line.laminar_resistance': 1.0}, (3e12, 1e13, 4e13)
    ),
    'galled_stem': Effect(
        'stem',
        ('position_dependent_friction',),
        {'stem.coulomb': 0.25, 'stem.galling': 1.0},
        (60.0, 200.0, 700.0),
    ),
    'galled_stem_above': Effect(
        'stem',
        ('position_dependent_friction',),
        {'stem.coulomb': 0.5, 'stem.galling': 1.0},
        (60.0, 200.0, 700.0),
        fixed={'stem.galled_at': 0.0115, 'stem.galled_over': 0.008},
    ),
}

NAMELESS: dict[str, Effect] = {**UNCATALOGUED, **FURTHER}

EFFECTS: dict[str, Effect] = {
    **CATALOGUED, **UNCATALOGUED, **VARIANTS, **FURTHER, **CHANGES, **LATER_VARIANTS}
