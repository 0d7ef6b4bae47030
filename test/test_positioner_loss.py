# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner whose model has no finite state any more says so, and publishes none of it."""

from __future__ import annotations

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from positioner_here import positioner_here, spinning
from positioner_process import Bench, report_of, with_parameters
import pytest
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64

SENTENCE = (
    'the model cannot be simulated with these parameters: its state is no finite number at '
    '0.020000000 s of simulated time, nothing is published until other parameters are set and '
    '/positioner/reset is called')


@pytest.fixture
def paused(ros_client):
    """Return a paused positioner in this process and a client of it."""
    with positioner_here(*with_parameters(start_paused='true')) as node, spinning(node):
        yield node, Bench(ros_client)


def lose_state(node):
    """Leave the model without a finite state, as equations do that run away."""
    plant = node._plant
    plant._y[:] = [math.nan] * len(plant._y)
    plant.parameters = plant.parameters  # what was reckoned ahead of the state goes with it


def levels(diagnostics):
    return [report_of(message, 'simulation').level for message in diagnostics]


def test_it_publishes_nothing_and_says_what_helps_until_it_is_reset(paused, capfd):
    node, bench = paused
    pressures, positions, stamped, state = bench.listen(
        chamber_pressure=Float64, valve_position=Float64, chamber_pressure_stamped=FluidPressure,
        positioner__state=DiagnosticArray)
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    bench.trigger('reset')
    bench.step(1)
    bench.client.spin_until(lambda: len(state) == 2 and len(diagnostics) > 0)
    assert levels(diagnostics)[-1] == DiagnosticStatus.OK

    lose_state(node)
    bench.set(step_ticks=20)
    response = bench.trigger('step')
    assert not response.success
    assert response.message == SENTENCE
    assert not bench.trigger('step').success
    bench.client.spin_until(lambda: DiagnosticStatus.ERROR in levels(diagnostics))
    assert report_of(diagnostics[-1], 'simulation').message == response.message
    assert capfd.readouterr().err.count(response.message) == 1
    # what the parameters become gives no state back
    assert bench.set(supply__pressure=390e3, step_ticks=1).successful
    assert not bench.trigger('step').success

    assert bench.trigger('reset').success
    bench.step(1)
    bench.client.spin_until(lambda: len(state) == 4)
    for messages in (pressures, positions, stamped, state):
        assert len(messages) == 4
    assert all(math.isfinite(message.data) for message in (*pressures, *positions))
    bench.client.spin_until(lambda: levels(diagnostics)[-1] == DiagnosticStatus.OK)


def test_a_running_one_keeps_its_time_and_resumes_after_a_reset(paused):
    node, bench = paused
    pressures, = bench.listen(chamber_pressure=Float64)
    lose_state(node)
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    assert bench.pause(False).success
    bench.client.spin_until(lambda: DiagnosticStatus.ERROR in levels(diagnostics))
    assert pressures == []
    assert bench.trigger('reset').success
    bench.client.spin_until(lambda: len(pressures) >= 5)
    assert all(math.isfinite(message.data) for message in pressures)
