# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the name plate says, and how far a real valve is from it."""

import numpy as np

from .plant import Valve

BENCH_SET = (150e3, 300e3)  # Pa gauge: the stem leaves 0, reaches the travel

# Relative standard deviations of what one finds between a valve and its name plate.
SPREADS: dict[str, dict[str, float]] = {
    'exact': {},
    # About what the identification of several units of one type gives.
    'samples': {
        'gain': 0.004,
        'time_constant': 0.07,
        'opening_gain': 0.025,
        'max_area': 0.025,
        'dead_volume': 0.035,
    },
    # A type whose name plate is less of a promise.
    'wide': {
        'gain': 0.008,
        'time_constant': 0.15,
        'opening_gain': 0.04,
        'max_area': 0.04,
        'dead_volume': 0.06,
        'area': 0.01,
        'bench_set': 0.002,
        'supply': 0.003,
        'viscous_friction': 0.2,
    },
    # What the model takes for granted of declared parameters until a record tells more.
    'tolerances': {
        'gain': 0.02,
        'time_constant': 0.15,
        'opening_gain': 0.06,
        'max_area': 0.06,
        'dead_volume': 0.06,
        'bench_set': 0.004,
        'supply': 0.015,
        'viscous_friction': 0.3,
    },
}


def drawn_valve(generator: np.random.Generator, spread: str) -> Valve:
    """
    Return a valve whose parameters are off their declared values as SPREADS[spread] says.

    Deviations are cut at two standard deviations. Spring rate and preload follow from the drawn
    bench set and area, so that a larger diaphragm alone changes volumes and forces, not pressures.
    """
    deviations = SPREADS[spread]

    def factor(name: str) -> float:
        return 1.0 + deviations.get(name, 0.0) * float(
            np.clip(generator.standard_normal(), -2.0, 2.0)
        )

    declared = Valve()
    converter, booster = declared.converter, declared.booster
    area = declared.chamber.area * factor('area')
    low, high = (bound * factor('bench_set') for bound in BENCH_SET)
    return declared._replace(
        converter=converter._replace(
            gain=converter.gain * factor('gain'),
            time_constant=converter.time_constant * factor('time_constant'),
        ),
        booster=booster._replace(
            opening_gain=booster.opening_gain * factor('opening_gain'),
            max_area=booster.max_area * factor('max_area'),
        ),
        supply=declared.supply._replace(pressure=declared.supply.pressure * factor('supply')),
        chamber=declared.chamber._replace(
            area=area, dead_volume=declared.chamber.dead_volume * factor('dead_volume')
        ),
        stem=declared.stem._replace(
            preload=area * low,
            spring_rate=area * (high - low) / declared.stem.travel,
            viscous_friction=declared.stem.viscous_friction * factor('viscous_friction'),
        ),
    )


def declared_groups() -> dict[str, dict[str, float | list[float]]]:
    """Return the declared parameters by group and name, SI units, pressures gauge."""
    valve = Valve()
    converter, booster, supply, chamber, stem = (
        valve.converter, valve.booster, valve.supply, valve.chamber, valve.stem,
    )  # fmt: skip
    return {
        'ep_converter': {
            'gain': converter.gain,
            'offset': converter.offset,
            'time_constant': converter.time_constant,
        },
        'booster': {
            's1': booster.s1,
            's2': booster.s2,
            's3': booster.s3,
            'opening_gain': booster.opening_gain,
            'max_area': booster.max_area,
            'critical_pressure_ratio': booster.critical_ratio,
        },
        'supply': {'pressure': supply.pressure, 'temperature': supply.temperature},
        'actuator': {
            'effective_area': chamber.area,
            'dead_volume': chamber.dead_volume,
            'polytropic_index': 1.0,
            'moving_mass': stem.mass,
            'bench_set': list(BENCH_SET),
            'travel': stem.travel,
            'viscous_friction': stem.viscous_friction,
        },
    }


def declared_yaml() -> str:
    """Return the declared parameters as a ROS 2 parameter file."""
    lines = ["# declared parameters of this record's positioner, SI units, pressures gauge"]
    lines += ['/**:', '  ros__parameters:']
    for group, values in declared_groups().items():
        lines.append(f'    {group}:')
        lines += [f'      {name}: {value!r}' for name, value in values.items()]
    return '\n'.join(lines) + '\n'
