# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner of another kind than declared is told by what it does to steps of the set point."""

from dataclasses import replace

from made_task import P
import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import split
from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.selection.neighbours import neighbours, refitted
from booster_ros.diagnosis.selection.task import Task

TIME = np.arange(0.0, 32.0, 0.05)
SET_POINT = 1e-3 * np.array([8.0, 11.0, 9.0, 9.4, 6.0, 6.2, 10.0, 9.0])[(TIME // 4.0).astype(int)]
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
TRIED = ('proportional_firmware', 'integrating_firmware', 'positioner_tuning', 'slew_limit')
LAWS = {'proportional_firmware': {'gain': 0.25, 'integral_time': 0.0, 'derivative_time': 0.03},
        'integrating_firmware': {'gain': 0.2, 'integral_time': 3.5}}


def loop(law):
    return P._replace(position_controller=P.position_controller._replace(enabled=True, **law))


@pytest.mark.campaign
def test_another_firmware_is_found_beside_whatever_else_slows_a_loop():
    true, declared = 'integrating_firmware', 'proportional_firmware'
    rng = np.random.default_rng(3)
    whole = Experiment(
        TIME, SET_POINT, {name: np.zeros(len(TIME)) for name in NOISE}, NOISE, {},
        Initial(225e3, valve_position=8e-3), command='set_point')
    experiment = replace(whole, measured={
        name: values + NOISE[name] * rng.standard_normal(len(TIME))
        for name, values in whole.predict(loop(LAWS[true])).items()})
    p = loop(LAWS[declared])
    task = Task(experiment, split(TIME, SET_POINT), p, free_to_refit(p, experiment), TRIED)
    root = refitted(task)
    near = neighbours(task, root, tuple(name for name in TRIED if name != declared)).near
    best = max(near, key=lambda one: one.score.log_evidence())
    assert best.effects == (true,)
    assert best.reduced_chi2 < 1.1 < 0.1 * root.reduced_chi2
    controller = best.fit.parameters.position_controller
    gain = controller.gain * np.exp(controller.gain_change)
    assert gain == pytest.approx(LAWS[true]['gain'], rel=0.1)
