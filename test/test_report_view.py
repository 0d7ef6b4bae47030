# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a diagnosis is drawn, and over what."""

from dataclasses import replace

from made_diagnosis import diagnosis_of, friction_found
from made_report import FROM, Page
import numpy as np

from booster_ros.report.html_report import html_page
from booster_ros.report.view import View


def test_rows_of_a_commanded_sweep_are_drawn_over_the_current_that_had_stood():
    current = np.linspace(0.42e-3, 0.46e-3, 30)
    pressure = np.linspace(180e3, 260e3, 30)
    made = diagnosis_of({'control_current': current, 'chamber_pressure': pressure}, 'none')
    view = View(made)
    assert view.driver == 'control_current'
    drawn = view.drive('control_current')
    compared = np.isfinite(made.experiment.measured['chamber_pressure'])
    np.testing.assert_allclose(drawn[compared], 1e3 * current[compared])
    assert np.array_equal(np.isnan(drawn), ~compared)
    assert 'control current, mA' in Page(html_page(made, FROM)).texts


def test_residuals_are_drawn_over_the_run_that_is_reported():
    """It begins where the fit found the valve, which is not where its first row reads."""
    made = friction_found()
    start = replace(made.experiment.initial, chamber_pressure=3e5)
    view = View(replace(made, start=start))
    expected = made.experiment.simulate(made.after, start)
    np.testing.assert_array_equal(view.states['chamber_pressure'], expected['chamber_pressure'])
    assert abs(View(made).states['chamber_pressure'][0] - 3e5) > 1e4
