# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A current that falls while the valve fills: of a reverse-acting converter, or of swapped wires.

The declared converter is direct-acting, whatever its parameters. Fitted all the same, such a record
comes out as one in which nearly all is missing.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import spearmanr

from booster_ros.diagnosis.data.experiment import Experiment, rmse
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.prepare.fit_metrics import EXPLAINED, FOLLOWS, alike
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError

Array = np.ndarray

STARTS = 41
"""Number of currents, over twice what opens the converter fully, from the best of which the search
for the current that was taken the other way begins: all but a few leave the valve shut or open."""

NEAR_ENOUGH = 1e-3
"""Share of the distance of two such currents to which the best is told."""

PRESSURES = ('back_pressure', 'chamber_pressure')


def check_current(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where the declared model moves as measured if the current is reversed."""
    name = next((name for name in PRESSURES if name in experiment.measured), '')
    if not name or experiment.quasi_static or experiment.in_loop:
        return
    measured = experiment.measured[name]
    rows = np.isfinite(measured)
    both = experiment.current[rows], measured[rows]
    if any(len(np.unique(each)) < 2 for each in both) or spearmanr(*both).statistic >= 0.0:
        return

    def turned(total: float) -> Array:
        return replace(experiment, current=total - experiment.current).predict(declared)[name]

    def left(total: float) -> float:
        return rmse(measured, turned(total), rows)

    most = float(np.max(experiment.current))
    full = declared.supply.pressure / declared.ep_converter.gain
    totals, step = np.linspace(most, most + 2.0 * full, STARTS, retstep=True)
    best = totals[int(np.argmin(side_by_side(left, totals)))]
    found = minimize_scalar(left, bounds=(best - step, best + step), method='bounded',
                            options={'xatol': NEAR_ENOUGH * step})
    given = rmse(measured, experiment.predict(declared)[name], rows)
    if found.fun < EXPLAINED * given and alike(measured, turned(found.x)) > FOLLOWS:
        raise RecordError(
            f'{source}, column control_current: the declared model moves as measured with '
            f'{found.x:.4g} A less the current: the converter is reverse-acting, or the wires are '
            'swapped; convert the column to the current of a direct-acting one')
