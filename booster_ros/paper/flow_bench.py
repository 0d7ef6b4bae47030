# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Table I's experiment on the model's booster: supply fixed, back pressure swept, outlet open.

Flows are in units of the table (`FLOW_UNIT`), pressures gauge, Pa.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares

from ..model.booster import Booster, diaphragm_force, intake_area, intake_flow
from ..model.supply import Supply
from .printed import FLOW_UNIT, FlowSeries

OUTLET = 0.0
"""The outlet is open: atmospheric, which is zero gauge (the paper mixes in 101.3 kPa here)."""

TEMPERATURE = Supply().temperature

Variant = Callable[[np.ndarray], Booster]
"""Makes a booster of the numbers that a fit turns, each about 1."""


def through_origin(scale: np.ndarray) -> Booster:
    """Return the paper's law, S = min(k F, Max), with k and Max scaled."""
    b = Booster()
    return b._replace(opening_gain=b.opening_gain * scale[0], max_area=b.max_area * scale[1])


def with_preload(scale: np.ndarray) -> Booster:
    """Return the law with a preload before the intake opens, the third number in units of 0.3 N."""
    return through_origin(scale)._replace(intake_preload=0.3 * scale[2])


def bench_force(booster: Booster, series: FlowSeries) -> np.ndarray:
    """Return the diaphragm force, N, at each row."""
    return np.array([
        diaphragm_force(booster, back, OUTLET, series.supply_pressure)
        for back in series.back_pressure
    ])


def bench_flow(booster: Booster, series: FlowSeries) -> np.ndarray:
    """Return the flow at each row in units of the table."""
    supply = series.supply_pressure
    flows = [
        intake_flow(
            booster, intake_area(booster, force, supply, OUTLET), supply, OUTLET,
            TEMPERATURE, TEMPERATURE)
        for force in bench_force(booster, series).tolist()
    ]
    return np.array(flows) / FLOW_UNIT


def misfit(booster: Booster, table: Sequence[FlowSeries]) -> np.ndarray:
    """Return model − printed over all rows, in units of the table."""
    return np.concatenate([bench_flow(booster, series) - series.mass_flow for series in table])


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def fit(variant: Variant, count: int, table: Sequence[FlowSeries]) -> Booster:
    """Return the booster of this kind, `count` numbers, that is nearest to the table."""
    # Knees and closed rows give the misfit several valleys, above all along the opening gain.
    found = [
        least_squares(
            lambda scale: misfit(variant(scale), table), [gain, *[1.1] * (count - 1)],
            bounds=(0.0, np.inf), diff_step=1e-3)
        for gain in (0.5, 1.0, 1.7, 2.5, 3.5)
    ]
    return variant(min(found, key=lambda solution: float(solution.cost)).x)


def left_out(variant: Variant, count: int, table: Sequence[FlowSeries]) -> float:
    """Return the RMS misfit of each supply pressure's rows to a fit of the others."""
    parts = []
    for series in table:
        others = [other for other in table if other is not series]
        parts.append(misfit(fit(variant, count, others), [series]))
    return rms(np.concatenate(parts))


def first_flow(booster: Booster, series: FlowSeries) -> tuple[float, float, float]:
    """
    Return the force at the last row without flow, N, at the first with flow, and a model's flow.

    The flow is what `booster` passes where none was measured, as a share of its largest.
    """
    last = int(np.flatnonzero(series.mass_flow == 0.0)[-1])
    force = bench_force(booster, series)
    flow = bench_flow(booster, series)
    return float(force[last]), float(force[last + 1]), float(flow[last] / flow.max())
