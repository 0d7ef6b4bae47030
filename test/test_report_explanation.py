# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a residual depends on."""

import numpy as np
import pytest

from booster_ros.report.explanation import best_explanation, explained_share


def test_the_variable_that_a_residual_depends_on_is_found():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-1.0, 1.0, (2, 2000))
    residual = x**2 + 0.1 * rng.standard_normal(2000)
    found = best_explanation(residual, {'x': x, 'y': y, 'constant': np.ones(2000)})
    assert found.variable == 'x'
    # bins cost a little
    assert found.share == pytest.approx(np.var(x**2) / np.var(residual), abs=0.05)
    assert explained_share(residual, y) < 0.05
    assert best_explanation(rng.standard_normal(2000), {'x': x, 'y': y}) is None
