# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which effects could turn Table III's simulated column into its measured one.

Each effect of the catalogue is added alone to the model that gives the simulated column, and its
sizes are fitted so that rise time, settling time and integral square error move as the measured
column differs. The E/P gain is turned along, because the final pressure did not differ and this
gain is what the paper would have set it with. Changes of indices are logarithms of ratios.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from ..diagnosis.estimation.parametrisation import Free, effect_freedom, put
from ..model.catalogue import EFFECTS
from ..model.parameters import ParameterError, check_consistent
from ..model.simulation import simulate
from ..model.system import PositionerParameters
from .indices import StepIndices
from .printed import PrintedIndex
from .step_test import RESPONSE, STEP_CURRENT, upward_steps

ROW = 2e-3
"""Rows of the played step, s; an index between two rows is off by far less."""

LEAD = 1.0
"""Rest before the step, s, without which a delay would not be seen."""

EXACT = 0.1
"""Multiple of the solver's default tolerance, so that differences of indices stay smooth."""

FINAL = 2e-4
"""Final pressures count as equal within this share: the half of its last printed digit."""

SMALL = 0.1
"""Size, relative to a typical one, at which an effect's direction is taken."""

STARTS = (0.1, 1.0, 3.0, 10.0)
"""Sizes, relative to typical ones, at which fits begin; the negative ones too where allowed."""

INVISIBLE = 1e-5
"""A change of the indices up to which an effect does not show in this experiment."""

_FAR = 10.0


class Suspect(NamedTuple):
    """
    What one effect can do for the measured column.

    `mismatch` is the RMS difference of three logarithms that is left. `cosine` is that of the
    angle between the wanted change and the nearest which small sizes make. `sizes` are values of
    the catalogue's parameters in SI units; `free` counts them.
    """

    name: str
    mismatch: float
    cosine: float
    sizes: dict[str, float]
    indices: StepIndices

    @property
    def free(self) -> int:
        """How many sizes were fitted."""
        return len(self.sizes)


def measured_change(printed: dict[str, PrintedIndex]) -> np.ndarray:
    """Return ln(measured / simulated) of the indices in the order of `StepIndices`."""
    return np.array([np.log(printed[name].measured / printed[name].simulated)
                     for name in StepIndices._fields])


def played(p: PositionerParameters) -> StepIndices:
    """Return the indices of the read pressure after 0 → 0.4524 mA; ValueError if unsettled."""
    time = np.arange(round((LEAD + RESPONSE) / ROW) + 1) * ROW
    current = np.where(time < LEAD, 0.0, STEP_CURRENT)
    run = simulate(p, time, current, tolerance=EXACT)
    (response,) = upward_steps(time, current, run['measured_chamber_pressure'])
    return response.indices()


def rank(wanted: np.ndarray, names: Iterable[str] = tuple(EFFECTS)) -> list[Suspect]:
    """Return these effects, nearest to the wanted change first; those that do not show left out."""
    found = [suspect(wanted, name) for name in names]
    return sorted((one for one in found if one is not None), key=lambda one: one.mismatch)


def suspect(wanted: np.ndarray, name: str) -> Suspect | None:
    """Return what this effect alone can do, None where this experiment does not show it."""
    freedoms = effect_freedom(EFFECTS[name])
    base = np.log(played(PositionerParameters()))
    cosine = _cosine(wanted, base, freedoms)
    if cosine is None:
        return None

    def residual(z: np.ndarray) -> np.ndarray:
        change = _change(base, freedoms, z)
        return _weighted(change - wanted)

    low = np.array([free.low for free in freedoms] + [-0.5])
    high = np.array([free.high for free in freedoms] + [0.5])
    fits = [
        least_squares(residual, np.clip(start, low + 1e-6, high - 1e-6), bounds=(low, high),
                      diff_step=3e-3, x_scale=np.r_[np.ones(len(freedoms)), 0.05], max_nfev=40)
        for start in _starts(freedoms)]
    best = min(fits, key=lambda fit: float(fit.cost))
    left = best.fun[1:]
    return Suspect(
        name, float(np.sqrt(np.mean(left**2))), cosine,
        {free.knob.parameter: free.value(z) for free, z in zip(freedoms, best.x)},
        played(_with(freedoms, best.x)))


def _weighted(difference: np.ndarray) -> np.ndarray:
    return difference / np.array([FINAL, 1.0, 1.0, 1.0])


def _with(freedoms: Sequence[Free], z: np.ndarray) -> PositionerParameters:
    """Return the paper's positioner with the effect; the last of z: ln of a factor on the gain."""
    p = PositionerParameters()
    for free, size in zip(freedoms, z):
        p = put(p, free.knob.parameter, free.value(float(size)), free.element)
    return put(p, 'ep_converter.gain', p.ep_converter.gain * float(np.exp(z[-1])))


def _change(base: np.ndarray, freedoms: Sequence[Free], z: np.ndarray) -> np.ndarray:
    """Return by how much the logarithms of the indices move, far away where there are none."""
    p = _with(freedoms, z)
    try:
        check_consistent(p)
        return np.asarray(np.log(played(p)) - base)
    except (ParameterError, ValueError):
        return np.full(len(base), _FAR)


def _starts(freedoms: Sequence[Free]) -> list[np.ndarray]:
    neutral = np.array([free.without_size for free in freedoms])
    is_size = np.array([not free.knob.shape for free in freedoms], dtype=float)
    signs = (1.0, -1.0) if any(free.low < -SMALL for free in freedoms if not free.knob.shape
                               ) else (1.0,)
    return [np.r_[neutral + sign * size * is_size, 0.0] for size in STARTS for sign in signs]


def _cosine(wanted: np.ndarray, base: np.ndarray, freedoms: Sequence[Free]) -> float | None:
    """
    Return the cosine between what is wanted and the nearest that small sizes do, None if nothing.

    The final pressure is kept by the E/P gain, whose own direction is taken out.
    """
    neutral = np.r_[[free.without_size for free in freedoms], 0.0]

    def direction(j: int, step: float) -> np.ndarray:
        moved = neutral.copy()
        moved[j] += step
        return _change(base, freedoms, moved) / step

    gain = direction(-1, 1e-3)
    columns, lowest = [], []
    for j, free in enumerate(freedoms):
        if free.knob.shape:
            continue
        raw = direction(j, SMALL)
        columns.append((raw - gain * raw[0] / gain[0])[1:])
        lowest.append(-np.inf if free.low < -SMALL else 0.0)
    matrix = np.column_stack(columns)
    size = np.linalg.norm(matrix, axis=0)
    shown = size > INVISIBLE
    if not shown.any():
        return None
    matrix = matrix[:, shown] / size[shown]
    found = lsq_linear(matrix, wanted[1:], (np.array(lowest)[shown], np.inf))
    return float(np.linalg.norm(matrix @ found.x) / np.linalg.norm(wanted[1:]))
