# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `twin` from alarm to adopted model, beside a real positioner and with real diagnoses."""

from __future__ import annotations

import json
from pathlib import Path
import signal
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros_client import RosClient
from ros_process import PATIENCE, ROOT, RosProcess, program
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from booster_ros.model.parameters import from_values, to_values
from booster_ros.nodes import remote_parameters
from booster_ros.nodes.positioner import Positioner
from booster_ros.nodes.ready import LATCHED
from booster_ros.nodes.remote_parameters import RemoteParameters
from booster_ros.nodes.twin import TwinNode
from booster_ros.testing import Valve
from booster_ros.twin.alarm import Alarm
from booster_ros.twin.memory import VERSION, Memory, OnTrial, recall, save
from booster_ros.twin.verdict import Verdict

RATE = 20.0
LEAK = 1e-7
HEALTHY = from_values({})
NOISE = {'publish_rate': RATE, 'integration_step': 0.05,
         'measurement.pressure_noise': 150.0, 'measurement.position_noise': 8e-6}
SETTINGS = {'block': 0.8, 'learning': 40.0, 'false_alarms': 1e5, 'drift': 5e-4,
            'history': 20.0, 'trial': 10.0, 'hypotheses': 'chamber_leak',
            'diagnosis_timeout': 110.0}


class Bench:
    """A valve, its twin, and who commands both and listens to the verdict."""

    def __init__(self, valve: Valve, **settings: object) -> None:
        self.valve = valve
        self.ticks = 0
        self.twin = TwinNode(context=valve.context,
                             parameter_overrides={**SETTINGS, **settings})
        self.node = Node('commander', context=valve.context)
        self.current = self.node.create_publisher(Float64, 'control_current', 10)
        self.verdicts: list[DiagnosticStatus] = []
        self.node.create_subscription(DiagnosticStatus, 'twin/verdict', self.verdicts.append,
                                      LATCHED)
        self.node.create_subscription(Float64, 'valve_position', lambda message: None, 10)
        self.state = ''
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._on_report, 10)
        valve.add(self.twin)
        valve.add(self.node)

    def _on_report(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == 'twin: diagnosis':
                self.state = status.message

    def move(self, seconds: float) -> None:
        for _ in range(round(seconds * RATE)):
            self.ticks += 1
            # so little motion that all blocks are of one operating cell
            angles = 2.0 * np.pi * np.array([0.11, 0.27, 0.43]) * self.ticks / RATE
            self.current.publish(Float64(data=0.433e-3 + 0.004e-3 * float(np.sin(angles).sum())))
            self.valve.step()
            if self.ticks % 5 == 0:
                self.twin.turn()
        self.twin.report()
        self.valve.turn()

    def ask(self, service: str) -> Trigger.Response:
        client = self.node.create_client(Trigger, f'twin/{service}')
        future = client.call_async(Trigger.Request())
        self.wait_for(future.done)
        return future.result()

    def wait_for(self, done, patience: float = PATIENCE) -> None:
        """Let real time pass, and none for the valve."""
        end = time.monotonic() + patience
        while not done():
            assert time.monotonic() < end
            self.valve.turn()
            self.twin.turn()
            time.sleep(0.05)

    @property
    def verdict(self) -> dict[str, str]:
        last = self.verdicts[-1]
        return {'message': last.message, **{one.key: one.value for one in last.values}}


def test_from_healthy_to_a_leak_that_is_adopted_and_known_after_a_restart(tmp_path):
    memory = tmp_path / 'twin.json'
    files = {'reports': str(tmp_path / 'reports'), 'memory': str(memory)}
    with Valve(NOISE) as valve:
        bench = Bench(valve, **files)
        assert bench.ask('adopt').message == (
            'no diagnosis has found anything that could be adopted')
        assert bench.ask('diagnose').message == '0 rows have come, 100 are needed'
        bench.move(52.0)
        assert bench.twin.twin.health.status == 'good', bench.twin.twin.health
        changed = bench.twin.twin.history.end
        valve.set({'actuator.leak_area': LEAK})
        while not bench.state.startswith('a diagnosis runs'):
            bench.move(5.0)
            assert bench.twin.twin.history.end < changed + 100.0, bench.state
        assert bench.ask('diagnose').message == 'a diagnosis runs already'
        bench.wait_for(lambda: bench.verdicts)
        told = bench.verdict
        assert told['effects'] == 'chamber_leak', told
        assert told['standing'] == 'confirmed'
        assert abs(float(told['since [s]']) - changed) < 10.0
        assert told['message'].startswith('the valve has chamber leak')
        # the report stands on a record of the leaking valve alone
        assert (Path(told['report']) / 'report.html').stat().st_size > 1000
        answer = bench.ask('adopt')
        assert answer.success, answer.message
        assert bench.ask('adopt').message == 'a model is on trial already'
        assert recall(memory, HEALTHY).model is None  # what is on trial is not kept
        bench.move(20.0)
        assert bench.verdict['adoption'].startswith('adopted: it predicted the next 10 s better')
        assert bench.ask('adopt').message.startswith('the model of the last verdict was adopted')
        found = bench.twin.twin.parameters
        assert found.actuator.leak_area == pytest.approx(LEAK, rel=0.1)
        assert recall(memory, HEALTHY).model == found
    with Valve({**NOISE, 'actuator.leak_area': LEAK}) as valve:
        again = Bench(valve, **files)
        assert again.twin.twin.parameters == found
        again.wait_for(lambda: again.verdicts)
        assert again.verdict['adoption'].startswith('adopted')


def verdict_in(folder: Path, **values: float) -> Verdict:
    """Return a verdict whose found model has these values."""
    folder.mkdir()
    lines = [f'    {name}: {value}' for name, value in values.items()]
    (folder / 'positioner.yaml').write_text('\n'.join(
        ['/**:', '  ros__parameters:', '    actuator:',
         *(f'  {line}' for line in lines), '']))
    return Verdict('found', 'it leaks', str(folder), 1.0, 'confirmed', ('chamber_leak',))


def test_a_model_that_predicts_worse_is_rolled_back_and_said(tmp_path):
    memory = tmp_path / 'twin.json'
    save(memory, HEALTHY, Memory(verdict=verdict_in(tmp_path / 'report', leak_area=LEAK)))
    with Valve(NOISE) as valve:
        other = Positioner(namespace='other', context=valve.context,
                           parameter_overrides={'start_paused': True})
        valve._executor.add_node(other)
        bench = Bench(valve, memory=str(memory), adopt_into='/other/positioner')

        def leak_of_the_other() -> float:
            return other.get_parameter('actuator.leak_area').value

        bench.move(10.0)
        assert bench.ask('adopt').success
        assert bench.twin.twin.parameters.actuator.leak_area == LEAK
        bench.wait_for(lambda: leak_of_the_other() == LEAK)
        trial = recall(memory, HEALTHY).on_trial
        assert (trial.positioner, trial.before['actuator.leak_area']) == ('/other/positioner', 0.0)
        bench.move(20.0)
        assert bench.verdict['adoption'].startswith('rolled back: it predicted')
        assert bench.twin.twin.parameters == HEALTHY
        bench.wait_for(lambda: leak_of_the_other() == 0.0)
        bench.wait_for(lambda: recall(memory, HEALTHY).on_trial is None)
        assert recall(memory, HEALTHY).model is None
        other.destroy_node()


def test_the_example_that_watches_adopts_what_is_confirmed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / 'examples')
    from twin_watch import TwinWatch
    memory = tmp_path / 'twin.json'
    save(memory, HEALTHY, Memory(verdict=verdict_in(tmp_path / 'report', leak_area=LEAK)))
    with Valve(NOISE) as valve:
        bench = Bench(valve, memory=str(memory))
        bench.move(10.0)
        watch = TwinWatch(context=valve.context)
        valve._executor.add_node(watch)
        bench.wait_for(lambda: bench.verdict['adoption'] == 'on trial')
        watch.destroy_node()


def test_an_end_during_the_trial_rolls_back(tmp_path):
    memory = tmp_path / 'twin.json'
    save(memory, HEALTHY, Memory(verdict=verdict_in(tmp_path / 'report', leak_area=LEAK)))
    with Valve(NOISE) as valve:
        bench = Bench(valve, memory=str(memory), trial=60.0)
        bench.move(10.0)
        assert bench.ask('adopt').success
        bench.move(5.0)
    with Valve(NOISE) as valve:
        again = Bench(valve, memory=str(memory))
        assert again.twin.twin.parameters == HEALTHY
        again.wait_for(lambda: again.verdicts)
        assert again.verdict['adoption'] == 'rolled back: the twin ended during the trial'


def test_an_alarm_without_a_verdict_is_answered_after_a_restart(tmp_path):
    files = {'reports': str(tmp_path / 'reports'), 'memory': str(tmp_path / 'twin.json')}
    with Valve(NOISE) as valve:
        bench = Bench(valve, **files)
        bench.move(10.0)
        bench.twin.twin.latched.append(
            Alarm(1.0, bench.twin.twin.history.end, 'valve_position', 'level', 0.1))
        bench.twin.remember()
        assert bench.state == 'nothing has been diagnosed yet'
    with Valve(NOISE) as valve:
        again = Bench(valve, **files)
        again.move(10.0)
        assert again.state.startswith('a diagnosis begins once a record of 20 s has come')


# A positioner that is given the model as well

@pytest.fixture
def both():
    """Return a positioner, and a node that speaks to it, with a function that lets both turn."""
    context = Context()
    rclpy.init(context=context)
    positioner = Positioner(context=context)
    node = Node('asks', context=context)
    executor = SingleThreadedExecutor(context=context)
    for one in (positioner, node):
        executor.add_node(one)

    def until(done, turn):
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end
            executor.spin_once(timeout_sec=0.02)
            turn()

    until.executor = executor
    yield positioner, node, until
    executor.shutdown()
    for one in (positioner, node):
        one.destroy_node()
    context.try_shutdown()


def test_a_positioner_is_given_the_model_and_set_back(both):
    positioner, node, until = both
    remote = RemoteParameters(node, 'positioner')
    leaks = from_values({'actuator.leak_area': LEAK, 'actuator.bench_set': (1.6e5, 3e5)})
    before, said = {}, []
    remote.exchange(to_values(leaks), before.update, said.append)
    until(lambda: said, remote.turn)
    assert said == ['']
    assert positioner.get_parameter('actuator.leak_area').value == LEAK
    assert before['actuator.leak_area'] == 0.0
    kept = json.loads(json.dumps(before))
    remote.put(kept, said.append)
    until(lambda: len(said) > 1, remote.turn)
    assert said == ['', '']
    assert positioner.get_parameter('actuator.leak_area').value == 0.0
    assert list(positioner.get_parameter('actuator.bench_set').value) == [1.5e5, 3e5]


def test_a_positioner_that_refuses_keeps_all_it_had(both):
    positioner, node, until = both
    remote = RemoteParameters(node, 'positioner')
    said = []
    remote.put({'actuator.leak_area': LEAK, 'supply.pressure': -1e9}, said.append)
    until(lambda: said, remote.turn)
    assert said[0].startswith('positioner refused: ')
    assert positioner.get_parameter('actuator.leak_area').value == 0.0


def test_a_positioner_that_is_not_there_is_given_up(both, monkeypatch):
    _, node, until = both
    monkeypatch.setattr(remote_parameters, 'PATIENCE', 0.3)
    remote = RemoteParameters(node, 'nobody')
    said = []
    remote.put({'actuator.leak_area': LEAK}, said.append)
    until(lambda: said, remote.turn)
    assert said == ['nobody did not answer within 0.3 s']


def test_a_positioner_left_with_a_model_on_trial_is_set_back_after_a_restart(both, tmp_path):
    positioner, node, until = both
    memory = tmp_path / 'twin.json'
    positioner.set_parameters_atomically([Parameter('actuator.leak_area', value=LEAK)])
    save(memory, HEALTHY, Memory(on_trial=OnTrial('positioner', {'actuator.leak_area': 0.0})))
    twin = TwinNode(context=node.context, parameter_overrides={'memory': str(memory)})
    until.executor.add_node(twin)
    until(lambda: positioner.get_parameter('actuator.leak_area').value == 0.0, lambda: None)
    until(lambda: recall(memory, HEALTHY).on_trial is None, lambda: None)
    twin.destroy_node()


# The process

def twin_process(*parameters: str) -> RosProcess:
    words = [word for one in parameters for word in ('-p', one)]
    return RosProcess(program('twin', '--ros-args', *words))


def test_a_damaged_memory_is_said_and_made_anew(tmp_path):
    memory = tmp_path / 'twin.json'
    memory.write_text(f'{{"version": {VERSION}, "digest": "0", "content": "{{}}"}}')
    with twin_process(f'memory:={memory}') as node:
        line = node.wait_for('is damaged')
        assert 'twin.json.aside, and a new one is made' in line
        node.send(signal.SIGKILL)
        node.wait()
    assert recall(memory, HEALTHY) == Memory()
    aside = tmp_path / 'twin.json.aside'
    for given, complaint in (
            (f'memory:={tmp_path}', f'memory: {tmp_path}: Is a directory'),
            (f'reports:={aside}', f'reports: {aside}: File exists')):
        with twin_process(given) as node:
            assert node.wait() == 2
            assert node.stderr == [f'twin: {complaint}']


def test_a_kill_of_the_node_at_any_moment_leaves_its_memory_whole(tmp_path):
    memory = tmp_path / 'twin.json'
    save(memory, HEALTHY, Memory(from_values({'actuator.leak_area': LEAK}),
                                 {'model': '', 'filling': [0.5] * 50_000}))
    with twin_process(f'memory:={memory}') as node, RosClient() as client:
        node.wait_for('the model that was adopted before the restart goes on')
        asking = client.node.create_client(Trigger, 'twin/acknowledge')
        client.spin_until(asking.service_is_ready)
        for _ in range(200):  # each is a writing
            asking.call_async(Trigger.Request())
        for _ in range(5):
            client.spin_once()
        node.send(signal.SIGKILL)
        node.wait()
    kept = recall(memory, HEALTHY)
    assert kept.model.actuator.leak_area == LEAK
    assert kept.calibration['filling'] == [0.5] * 50_000
    with twin_process(f'memory:={memory}') as node:
        node.wait_for('the model that was adopted before the restart goes on')
        assert 'damaged' not in node.output
