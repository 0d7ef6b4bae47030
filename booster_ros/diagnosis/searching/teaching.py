# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What the select segments alone can teach a model: a limit that no fit segment reached, say.

A model that leaves noise wherever it was fitted may miss a segment that it was not fitted to. That
is no fault of what was added to the model. So it is fitted to the select segments as well, and
counts if it then leaves noise in each of them; the locked part stays closed.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from booster_ros.diagnosis.searching.candidate import NEAR_NOISE, Candidate
from booster_ros.diagnosis.searching.search import Search

Array = np.ndarray

PLAUSIBLE = 12.0
"""Sum of squared departures of the declared parameters that their priors still allow."""

PATCH, SELDOM = 1.3, 0.01
"""
Mean square misfit up to which a single segment is noise, and a probability: where a segment has so
few values that noise would leave more in one of the segments more often than that, the limit is
what noise exceeds so often.
"""


def fitted_to_noise(candidate: Candidate) -> bool:
    """Tell whether a model leaves noise where it was fitted."""
    return candidate.fitted_misfit < NEAR_NOISE


def taught(search: Search, candidate: Candidate) -> Candidate | None:
    """
    Return the same model fitted to the select segments as well, if that leaves noise.

    Then nothing is missing. Noise must be all that is left in each of them: what shows in few is
    no noise. Where the stem sticks, the model is taught only if it leaves noise in the fit
    segments already, as that fit takes long.
    """
    if candidate.fit.sticks and not fitted_to_noise(candidate):
        return None
    both = search.on_both(candidate, search.thinning)
    noise = fitted_to_noise(both) and (
        both.by_segment <= most_by_noise(search.values_held_back())).all()
    return both if noise and _departures(both) < PLAUSIBLE else None


def most_by_noise(values: Array) -> Array:
    """Return the sum of squares that noise leaves at most in each segment of so many values."""
    return np.maximum(PATCH * values, chi2.ppf(1.0 - SELDOM / len(values), np.maximum(values, 1)))


def _departures(candidate: Candidate) -> float:
    """Return the sum of squared departures of the declared parameters; no table values count."""
    return sum((z / free.sigma)**2 for z, free in zip(candidate.fit.z, candidate.fit.freedoms)
               if np.isfinite(free.sigma) and free.knob.parameter != 'discrepancy.values')


def taught_what_it_missed(search: Search, candidate: Candidate) -> Candidate | None:
    """Return the model taught, if all that it misses is in segments that it was not fitted to."""
    misses = candidate.misfit > NEAR_NOISE and fitted_to_noise(candidate)
    both = taught(search, candidate) if misses and not candidate.fault else None
    return both and replace(both, confirmed=candidate.confirmed, lasting=candidate.lasting)
