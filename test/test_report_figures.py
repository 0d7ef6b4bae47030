# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of many rows as figures draw them: gaps and peaks stay."""

import numpy as np
import pytest

from booster_ros.report.thinning import envelope, over_time


@pytest.mark.parametrize('rows', [200, 100_000])
def test_a_line_over_time_is_not_drawn_across_a_gap(rows):
    time = 0.01 * np.arange(float(rows))
    time[rows // 2:] += 50.0
    x, y = over_time(time, np.sin(time))
    here, = np.flatnonzero(np.isnan(y))
    assert x[here - 1] < time[rows // 2 - 1] + 1e-9
    assert x[here] == time[rows // 2] <= x[here + 1]
    assert np.all(np.diff(x) >= 0.0)
    x, y = over_time(0.01 * np.arange(float(rows)), np.sin(time))
    assert np.isfinite(y).all()


def test_a_thinned_line_keeps_its_peaks_and_its_gaps():
    y = np.zeros(100_000)
    y[41_234], y[77_001] = 5.0, -3.0
    y[50_000:60_000] = np.nan
    x, thinned = envelope(np.arange(100_000.0), y)
    assert len(x) < 2000
    assert (np.nanmax(thinned), np.nanmin(thinned)) == (5.0, -3.0)
    assert np.isnan(thinned[(x > 51_000) & (x < 59_000)]).all()
    assert (np.diff(x) >= 0.0).all()
