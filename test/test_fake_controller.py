# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node `fake_controller` against a positioner in another process, or in another thread.

What depends on the process itself, on its signals, its status and what it prints, is shown with a
controller in a process of its own, the rest with one in the process of the test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
import contextlib
import io
from pathlib import Path
import signal
import threading
import time
from types import SimpleNamespace

from controller_here import played
import numpy as np
from positioner_here import context_here
import positioner_process
from positioner_process import with_parameters
import pytest
from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_client import RosClient
from ros_process import HANGUP, PATIENCE, ROOT, RosProcess, program
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, String

from booster_ros.model.parameters import ParameterError, from_values
from booster_ros.model.simulation import Plant
from booster_ros.nodes.current_limits import AGAIN, LIMITS, CurrentLimits
from booster_ros.nodes.fake_controller import FakeController
from booster_ros.nodes.positioner import Positioner
from booster_ros.nodes.progress import Progress
from booster_ros.nodes.silence import Silence
from booster_ros.records import Record, read_record
from booster_ros.run_error import RunError

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

RATE, STEP = 20, 0.01
"""
Ticks per second and integration step, s, of the positioner that tests share.

By both it takes less of the computing time than with its defaults.
"""


def controller(*ros_arguments: str, **parameters: object) -> RosProcess:
    arguments = [*ros_arguments, *with_parameters(**parameters)]
    return RosProcess(program('fake_controller', '--ros-args', *arguments))


def gives_up(
    *ros_arguments: str, until: Callable[[FakeController], bool] | None = None, **parameters: object
) -> str:
    """
    Return what a controller in this process says that it cannot do.

    Where it waits for a positioner, it gives up as soon as `until` says that it knows enough.
    """
    with context_here(*ros_arguments, *with_parameters(**parameters)) as arguments:
        try:
            node = FakeController(arguments)
        except ParameterError as error:
            return str(error)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        end = time.monotonic() + PATIENCE
        try:
            while until is not None and not until(node):
                assert time.monotonic() < end
                executor.spin_once(timeout_sec=0.05)
            if until is not None:
                node._settings = node._settings._replace(wait_timeout=1e-9)
            with pytest.raises(RunError) as refused:
                executor.spin()
        finally:
            executor.shutdown()
            node.destroy_node()
    return str(refused.value)


@contextlib.contextmanager
def valve(namespace: str, **parameters: object) -> Iterator[Callable[[], None]]:
    """Run a positioner in a thread; return what makes it hang, and DDS not notice."""
    context = Context()
    rclpy.init(context=context)
    node = Positioner(
        namespace=namespace, context=context,
        parameter_overrides={'publish_rate': 50.0, 'integration_step': STEP, **parameters})
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()

    def hang() -> None:
        executor.shutdown()
        thread.join()

    try:
        yield hang
    finally:
        hang()
        node.destroy_node()
        context.try_shutdown()


def knows(node: FakeController, namespace: str, pressures: int) -> bool:
    """Tell whether the controller has found what the test publishes, and who that is."""
    def publishers(topic: str) -> list[str]:
        found = node.get_publishers_info_by_topic(f'{namespace}/{topic}')
        return [one.node_name for one in found]

    return (node.count_subscribers(f'{namespace}/control_current') == 1
            and publishers('chamber_pressure') == ['test_client'] * pressures
            and publishers('valve_position') == ['test_client'])


@pytest.fixture(scope='module')
def positioner() -> Iterator[RosProcess]:
    """Return a positioner that several tests drive, one after the other."""
    with positioner_process.start(
            *with_parameters(publish_rate=float(RATE), integration_step=STEP)) as node:
        yield node


def replayed(record: Record) -> Plant:
    """Check that the model, driven by the record's current, gives its outputs; return the model."""
    plant = Plant(from_values({}), STEP)
    outputs = []
    for current in record['control_current']:
        outputs.append(plant.outputs())
        plant.advance(current, round(1.0 / RATE / STEP))
    for name, resolution in (('chamber_pressure', 0.01), ('valve_position', 1e-8)):
        modelled = [getattr(output, f'measured_{name}') for output in outputs]
        np.testing.assert_allclose(record[name], modelled, rtol=0.0, atol=resolution)
    return plant


def test_a_recording_in_lockstep_is_what_the_model_says(tmp_path, positioner):
    """Every command counts from the very tick it was sent for, whatever the processes do."""
    csv, bag = tmp_path / 'record.csv', tmp_path / 'record'
    profile = {'profile': 'sines', 'low': 3.8e-4, 'high': 4.6e-4, 'frequencies': [0.5, 1.3],
               'cycles': 2, 'rate': RATE, 'lockstep': True, 'record_csv': csv}
    with controller(feedback='plain', record_bag="''", **profile) as node:
        assert node.wait() == 0, node.output
    plain = csv.read_bytes()
    assert played(feedback='stamped', record_bag=bag, **profile) == ''
    assert csv.read_bytes() == plain
    record = read_record(csv)
    assert len(record) == 4 * RATE + 1
    np.testing.assert_allclose(record['time'], np.arange(4 * RATE + 1) / RATE, atol=1e-9)
    assert len(np.unique(record['control_current'])) > 2 * RATE
    assert replayed(record).outputs().valve_position > 0.0
    from_bag = read_record(bag)
    for name in record.columns:
        np.testing.assert_allclose(from_bag[name], record[name], rtol=1e-6, atol=1e-3)


def test_a_profile_is_played_in_real_time_and_recorded(tmp_path, positioner, ros_client):
    csv, bag = tmp_path / 'record.csv', tmp_path / 'record'
    commands = ros_client.listen('control_current', Float64)
    phases = ros_client.listen('fake_controller/status', String)
    with controller(
        levels=[2e-4, 4e-4], dwell=1.5, feedback='stamped', record_csv=csv, record_bag=bag,
        bag_format='sqlite3',
    ) as node:
        assert node.wait() == 0, node.output
        assert any('1.5 of 3 s played, 50%' in line for line in node.stderr)
    ros_client.spin_until(lambda: 'done' in [phase.data for phase in phases])
    # a busy machine may connect this client after the first of them
    assert [phase.data for phase in phases] in (
        ['waiting', 'playing', 'done'], ['playing', 'done'], ['done'])
    # the first level stands for so long that such a client sees it as well
    ros_client.spin_until(lambda: {command.data for command in commands} == {2e-4, 4e-4})
    record = read_record(csv)
    # it ends with the last sample that came in time; a busy machine delivers the last ones late
    assert 1.9 < record['time'][-1] < 3.1
    np.testing.assert_allclose(np.diff(record['time']), 1.0 / RATE, atol=2e-6)
    first_high = np.flatnonzero(record['control_current'] == 4e-4)[0]
    assert record['control_current'][first_high - 1] == 2e-4
    assert 1.44 < record['time'][first_high] < 3.0  # never early; a busy machine sends it late
    assert set(read_record(bag).columns) == set(record.columns)


def test_what_had_waited_on_a_topic_is_over_before_the_profile_begins(
    tmp_path, positioner, capfd
):
    csv = tmp_path / 'record.csv'
    assert played(levels=[2e-4], dwell=0.3, record_csv=csv) == ''
    said = {line.split()[-1]: float(line.split('[')[2].split(']')[0])
            for line in capfd.readouterr().err.splitlines()
            if line.endswith(('waiting', 'playing'))}
    assert said['playing'] - said['waiting'] > 0.5
    first = {name: values[0] for name, values in read_record(csv).columns.items()}
    assert np.isfinite(list(first.values())).all()


def test_a_recording_needs_every_output(tmp_path, ros_client):
    ros_client.node.create_subscription(Float64, '/half/control_current', lambda message: None, 10)
    for name in ('chamber_pressure', 'valve_position'):
        ros_client.node.create_publisher(Float64, f'/half/{name}', 10)
    csv = tmp_path / 'none.csv'
    said = gives_up('-r', '__ns:=/half', record_csv=csv, feedback='plain',
                    until=lambda node: knows(node, '/half', 1))
    assert said.endswith(': no chamber_pressure has come, no valve_position has come')
    assert not csv.exists()
    said = gives_up('-r', '__ns:=/half', wait_timeout=0.3, record_csv=csv)
    assert 'nobody publishes /half/chamber_pressure_stamped' in said
    assert said.endswith('; feedback: plain listens to topics without a time stamp')


def test_two_positioners_on_the_same_topics_are_not_recorded(tmp_path, ros_client):
    """None of them publishes, so that the order in which they are discovered does not matter."""
    crowd = ros_client.node
    crowd.create_subscription(Float64, '/crowd/control_current', lambda message: None, 10)
    for name in ('chamber_pressure', 'chamber_pressure', 'valve_position'):
        crowd.create_publisher(Float64, f'/crowd/{name}', 10)
    here = ('-r', '__ns:=/crowd')
    csv = tmp_path / 'record.csv'
    said = gives_up(*here, levels=[2e-4], dwell=0.5, record_csv=csv, feedback='plain',
                    until=lambda node: knows(node, '/crowd', 2))
    name = crowd.get_fully_qualified_name()
    assert f'several publish /crowd/chamber_pressure ({name}, {name})' in said
    assert 'several publish /crowd/valve_position' not in said
    assert not csv.exists()
    assert played(*here, levels=[2e-4], dwell=0.2) == ''  # it drives them all: no matter


def test_a_positioner_that_ends_ends_the_profile(tmp_path, capfd):
    csv = tmp_path / 'record.csv'
    with contextlib.ExitStack() as running:
        running.enter_context(valve('/mortal'))
        said = played('-r', '__ns:=/mortal', dwell=100.0, record_csv=csv, then=running.close)
    assert 'the positioner has gone' in said
    assert 'partial' in capfd.readouterr().err
    assert len(read_record(csv)) > 10


def test_of_a_positioner_that_has_gone_nobody_is_told_to_let_it_go_on(capfd):
    with contextlib.ExitStack() as running:
        running.enter_context(valve('/mortal'))
        said = played('-r', '__ns:=/mortal', rate=50.0, lockstep=True, dwell=1e4,
                      then=running.close)
    assert 'the positioner has gone' in said
    output = capfd.readouterr().err
    assert 'interrupted after' in output
    assert 'stays paused' not in output


def test_a_second_positioner_that_comes_later_ends_the_recording(
    tmp_path, positioner, ros_client, capfd
):
    csv = tmp_path / 'record.csv'

    def come() -> None:
        ros_client.node.create_publisher(Float64, 'valve_position', 10)

    said = played(dwell=100.0, record_csv=csv, feedback='plain', then=come)
    assert 'several publish /valve_position (' in said
    assert 'partial' in capfd.readouterr().err
    assert len(read_record(csv)) > 10


def test_a_killed_positioner_is_missed_at_once_and_the_old_recording_stays(tmp_path):
    """DDS goes on for 20 s as if it were there."""
    csv = tmp_path / 'record.csv'
    csv.write_text('old')
    shot = ('-r', '__ns:=/shot')
    with positioner_process.start(
            *shot, *with_parameters(publish_rate=50.0, integration_step=STEP)) as node:
        said = played(*shot, levels=[3e-4], dwell=1e4, record_csv=csv,
                      then=lambda: node.send(signal.SIGKILL))
    assert said.startswith('nothing has come from the positioner in the last')
    assert csv.read_text() == 'old'
    assert len(read_record(tmp_path / 'record.partial.csv')) > 10


def test_of_a_positioner_that_hangs_in_lockstep_nobody_is_told_to_let_it_go_on(tmp_path, capfd):
    """For DDS it is there; nobody is there to be advised."""
    csv = tmp_path / 'record.csv'
    csv.write_text('old')
    with valve('/hanging') as hang:
        said = played('-r', '__ns:=/hanging', levels=[3e-4], dwell=1e4, rate=50.0, lockstep=True,
                      record_csv=csv, then=hang)
    assert said.startswith('nothing has come from the positioner in the last')
    output = capfd.readouterr().err
    assert 'partial' in output
    assert 'stays paused' not in output
    assert csv.read_text() == 'old'
    assert len(read_record(tmp_path / 'record.partial.csv')) > 10


def test_a_profile_that_ends_in_silence_ends_like_an_interruption(tmp_path):
    csv = tmp_path / 'record.csv'
    csv.write_text('old')
    with context_here('-r', '__ns:=/alone', '-p', f'record_csv:={csv}') as arguments:
        node = FakeController(arguments)
        node._pace._begin = 100
        node.begin(100)
        for stamp in (100, 200, 300):
            node.send(0.0, stamp)
            for column in ('chamber_pressure', 'valve_position'):
                node._on_output(column, 1.0, stamp)
        node._silence._since -= 60.0
        with pytest.raises(RunError, match=r'in the last 60\.\d s \(it has ended, hangs or is p'):
            node.finish()
        node.destroy_node()
    assert csv.read_text() == 'old'
    assert (tmp_path / 'record.partial.csv').exists()


def test_a_lockstep_that_is_interrupted_says_that_the_positioner_is_paused():
    with valve('/held'), controller(
            '-r', '__ns:=/held', rate=50.0, lockstep=True, dwell=1e4) as node:
        node.wait_for('playing')
        time.sleep(0.3)
        assert node.interrupt() == 0
    assert 'ros2 service call /held/positioner/pause std_srvs/srv/SetBool' in node.output


def test_silence_is_what_is_longer_than_usual():
    silence = Silence()
    silence.heard(100.0)
    assert silence.lasts(1000.0) == 0.0  # no pause is known yet
    for moment in (100.5, 101.0, 102.0):
        silence.heard(moment)
    assert silence.lasts(106.4) == 0.0
    assert silence.lasts(106.6) == pytest.approx(4.6)
    silence.excuse(106.6)
    assert silence.lasts(111.0) == 0.0
    silence.heard(111.0)  # what was excused was no pause
    assert silence.lasts(125.6) == 0.0
    assert silence.lasts(125.8) == pytest.approx(14.8)


def test_the_position_loop_moves_the_stem_to_the_set_point(tmp_path, positioner):
    csv = tmp_path / 'record.csv'
    assert played(mode='position', levels=[0.008], dwell=8.0, rate=RATE, lockstep=True,
                  record_csv=csv) == ''
    record = read_record(csv)
    assert record['valve_position'][-1] == pytest.approx(0.008, abs=2e-4)
    replayed(record)


@pytest.mark.parametrize('first', [signal.SIGINT, signal.SIGTERM, HANGUP])
def test_an_interrupted_recording_is_complete_and_said_to_be_partial(tmp_path, positioner, first):
    csv, bag = tmp_path / 'record.csv', tmp_path / 'record'
    # filling: what is left in a chamber that vents may be so little that it is read as kPa
    with controller(levels=[0.4524e-3], dwell=100.0, record_csv=csv, record_bag=bag) as node:
        node.wait_for('playing')
        time.sleep(0.5)
        assert not csv.exists()
        node.send(first)
        time.sleep(0.003)
        assert node.interrupt() == 0, node.output
        assert 'partial' in node.output
        assert 'Traceback' not in node.output
    assert 2 < len(read_record(csv)) < 10_000
    assert len(read_record(bag)) > 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ['record', 'record.csv']


def test_keep_alive_goes_on_sending_and_the_status_is_latched(positioner, ros_client):
    with controller(levels=[1e-4], dwell=0.1, keep_alive=True) as node:
        node.wait_for('done')
        late: list[String] = []
        ros_client.node.create_subscription(String, 'fake_controller/status', late.append, LATCHED)
        ros_client.spin_until(lambda: bool(late))
        assert late[0].data == 'done'
        assert [m.data for m in ros_client.receive('control_current', Float64, 5)] == [1e-4] * 5
        assert node.interrupt() == 0, node.output


def test_simulated_time_sets_the_pace(tmp_path, ros_client):
    """The profile lasts six simulated seconds, which pass in a fraction of real ones."""
    csv = tmp_path / 'record.csv'
    clock = ros_client.node.create_publisher(Clock, '/clock', 10)
    simulated, stamps = 100.0, []
    ros_client.node.create_subscription(
        FluidPressure, '/sim/chamber_pressure_stamped',
        lambda message: stamps.append(message.header.stamp.sec
                                      + 1e-9 * message.header.stamp.nanosec), 10)
    with valve('/sim', use_sim_time=True, publish_rate=float(RATE)), controller(
        '-r', '__ns:=/sim', use_sim_time=True, levels=[2e-4, 4e-4], dwell=3.0, rate=RATE,
        feedback='stamped', record_csv=csv,
    ) as node:
        end = time.monotonic() + PATIENCE
        while not node.over() and time.monotonic() < end:
            message = Clock()
            message.clock.sec, rest = divmod(round(simulated * 1e9), 10**9)
            message.clock.nanosec = rest
            clock.publish(message)
            simulated += 0.025
            time.sleep(0.002 if 'playing' in node.output else 0.05)
            # the clock waits for a busy machine, as far as what it sends may get lost on the way
            with contextlib.suppress(AssertionError):
                ros_client.spin_until(
                    lambda shown=simulated: not stamps or shown - stamps[-1] < 0.15, timeout=1.0)
        assert node.wait() == 0, node.output
    record = read_record(csv)
    # On wall time the step would come when this clock is far beyond. What is not connected yet
    # when the profile begins is missing from the record.
    assert 5.5 < record['time'][-1] < 6.2
    first_high = np.flatnonzero(record['control_current'] == 4e-4)[0]
    assert record['time'][first_high] == pytest.approx(3.0, abs=0.5)


@pytest.mark.parametrize(('parameters', 'says'), [
    ({'levles': 1.0}, 'there is no parameter levles; did you mean levels?'),
    ({'rate': -1}, 'rate'),
    ({'levels': [0.0, 0.4524]}, 'is it in mA?'),
    ({'profile': 'csv', 'csv_file': '/no/file.csv'}, '/no/file.csv: No such file'),
    ({'record_csv': '/no/folder/x.csv'}, '/no/folder/x.csv cannot be written'),
    ({'record_csv': '/'}, '/ cannot be written: it is a folder'),
    ({'wait_timeout': 0.3}, 'nobody subscribes to /alone/control_current'),
    ({'wait_timeout': 0.3, 'lockstep': True}, 'there is no /alone/positioner/step'),
    ({'wait_timeout': 0.3, 'lockstep': True}, 'there is no /alone/positioner/get_parameters'),
])
def test_what_it_cannot_do_it_says_in_a_sentence(parameters, says):
    said = gives_up('-r', '__ns:=/alone', **parameters)
    assert says in said
    assert '\n' not in said


def complaint_of(node: RosProcess) -> str:
    """Return the one line that a process prints which cannot go on."""
    assert node.wait() == 2, node.output
    complaint, = (line for line in node.stderr if not line.startswith('['))
    return complaint


def test_an_empty_list_ends_the_process_with_a_sentence():
    with controller('-r', '__ns:=/alone', levels=[]) as node:
        assert 'an empty list ([]) is no value of a parameter' in complaint_of(node)


def test_what_ends_a_run_is_no_bad_parameter():
    with context_here('-r', '__ns:=/alone', '-p', 'wait_timeout:=0.1') as arguments:
        node, executor = FakeController(arguments), SingleThreadedExecutor()
        executor.add_node(node)
        try:
            with pytest.raises(RunError, match='nobody subscribes to /alone/control_current'):
                executor.spin()
        finally:
            executor.shutdown()
            node.destroy_node()


@pytest.mark.parametrize(('line', 'says'), [
    ('profil: triangle', 'there is no parameter profil; did you mean profile?'),
    ('rate: fast', "rate must be a number in Hz, got 'fast' (write for example 100.0)"),
    ('mode: both', "mode must be one of current, position, set_point, got 'both'"),
])
def test_a_bad_parameter_in_a_file_is_said_with_its_line(tmp_path, line, says):
    params = tmp_path / 'params.yaml'
    params.write_text(
        f'other:\n  ros__parameters:\n    {line}\n/**:\n  ros__parameters:\n    {line}\n')
    assert gives_up('--params-file', str(params)) == f'{params}, line 6: {says}'


def test_a_file_that_is_read_is_not_recorded_to(tmp_path):
    profile, params = tmp_path / 'profile.csv', tmp_path / 'params.yaml'
    profile.write_text('time,control_current\n0,0.0004\n1,0.0004\n')
    params.write_text('/**:\n  ros__parameters:\n    wait_timeout: 0.2\n')
    for given in (profile, params):
        before = given.read_text()
        said = gives_up('--params-file', str(params), '-r', '__ns:=/alone', profile='csv',
                        csv_file=profile, record_csv=given)
        assert said == (
            f'recording: {given}: is read, and would be overwritten; choose another record_csv')
        assert given.read_text() == before


def test_nothing_is_left_of_a_recording_that_never_began(tmp_path):
    with controller(
        '-r', '__ns:=/alone', wait_timeout=0.2, record_csv=tmp_path / 'x.csv',
        record_bag=tmp_path / 'x',
    ) as node:
        assert 'nobody subscribes to /alone/control_current' in complaint_of(node)
    assert not list(Path(tmp_path).iterdir())


def test_lockstep_needs_the_rate_of_the_positioner_and_says_so_before_it_plays(
    tmp_path, positioner
):
    csv = tmp_path / 'record.csv'
    csv.write_text('old')
    with controller(
        rate=50.0, lockstep=True, record_csv=csv, record_bag=tmp_path / 'record',
    ) as node:
        assert 'publish_rate / step_ticks of positioner, 20 Hz' in complaint_of(node)
        assert 'playing' not in node.output
        assert 'interrupted' not in node.output
    assert csv.read_text() == 'old'
    assert list(tmp_path.iterdir()) == [csv]


def test_a_recording_without_a_row_replaces_nothing(tmp_path, positioner, capfd):
    csv = tmp_path / 'record.csv'
    csv.write_text('old')
    said = played(levels=[3e-3], dwell=1.0, record_csv=csv, record_bag=tmp_path / 'record')
    assert 'cannot be recorded' in said
    assert 'interrupted after 0.00 of 1 s; partial: nothing recorded' in capfd.readouterr().err
    assert csv.read_text() == 'old'
    assert list(tmp_path.iterdir()) == [csv]


def test_an_interrupted_recording_leaves_the_one_that_is_there(tmp_path, positioner, capfd):
    csv, beside = tmp_path / 'record.csv', tmp_path / 'record.partial.csv'
    csv.write_text('old')
    # what rclpy's handler of a signal does
    said = played(levels=[0.4524e-3], dwell=100.0, record_csv=csv, then=rclpy.shutdown)
    assert said == ''
    assert f'samples recorded to {beside}' in capfd.readouterr().err
    assert csv.read_text() == 'old'
    assert 2 < len(read_record(beside)) < 10_000


@pytest.mark.parametrize('lockstep', [False, True])
def test_a_current_that_the_positioner_refuses_is_not_recorded(tmp_path, lockstep):
    """It stays at the one before: a row with the one that was sent would be false."""
    csv = tmp_path / 'record.csv'
    with valve('/strict'):
        said = played('-r', '__ns:=/strict', levels=[1e-4, 3e-3], dwell=1.0, rate=50.0,
                      lockstep=lockstep, record_csv=csv)
    assert said.startswith('0.003 A is outside the current_limits of ')
    assert said.endswith(
        'positioner, 0 to 0.002 A: it does not follow that, so that it cannot be recorded')
    record = read_record(csv)
    assert set(record['control_current']) == {1e-4}
    # a busy machine sends late, and receives later
    assert 0.5 < record['time'][-1] < (1.2 if lockstep else 3.0)


def test_of_a_current_that_the_positioner_refuses_is_warned_once(positioner, capfd):
    """In the position loop, which begins at 4 mA here."""
    assert played(mode='position', levels=[0.008], dwell=0.5, loop_bias=4e-3,
                  loop_current_limits=[0.0, 4e-3]) == ''
    output = capfd.readouterr().err
    assert output.count(' A is outside the current_limits of /positioner') == 1


def test_the_config_file_is_the_default_but_for_the_feedback(positioner, capfd):
    file = str(ROOT / 'config' / 'fake_controller.yaml')
    assert played('--params-file', file, dwell=0.05, rate=200) == ''
    line = next(
        line for line in capfd.readouterr().err.splitlines() if 'parameters in force' in line)
    assert 'levels (0.0, 0.0004524, 0.0, 0.0004524)' in line
    assert 'rate 200.0' in line
    assert 'feedback stamped' in line


def test_a_client_that_sees_the_commands_needs_no_positioner(ros_client: RosClient):
    """Whatever subscribes to control_current is a positioner; without a recording that suffices."""
    received = ros_client.listen('/stub/control_current', Float64)
    assert played('-r', '__ns:=/stub', levels=[3e-4], dwell=0.2) == ''
    ros_client.spin_until(lambda: len(received) >= 5)
    assert {message.data for message in received} == {3e-4}


def test_each_tenth_of_a_profile_is_told_once(monkeypatch):
    """Also where seconds divided by a tenth are a whole number but for rounding, as 22 / 4.4."""
    monkeypatch.setattr('sys.stderr', io.StringIO())
    told: list[str] = []
    progress = Progress(44.0, SimpleNamespace(info=told.append))
    for tick in range(4401):
        progress.show(tick / 100)
    assert [line.split()[-1] for line in told] == [f'{share}%' for share in range(10, 101, 10)]


def test_a_positioner_that_does_not_answer_is_asked_again():
    """Its answer to the first question is lost if it has not yet found who asks."""
    asked: list[str] = []

    def answer(request: GetParameters.Request, response: GetParameters.Response
               ) -> GetParameters.Response:
        asked.extend(request.names)
        response.values = [Parameter(LIMITS, value=[0.0, 2e-3]).get_parameter_value()]
        return response

    with context_here():
        node = rclpy.create_node('deaf', start_parameter_services=False)
        client = rclpy.create_node('asking')
        limits = CurrentLimits(client)
        try:
            node.create_service(GetParameters, '/deaf/get_parameters', answer)
            end = time.monotonic() + PATIENCE
            begun = time.monotonic()
            while len(asked) < 2 and time.monotonic() < end:
                limits.ask('/deaf', time.monotonic())
                time.sleep(0.02)
                if time.monotonic() > begun + 2.0 * AGAIN:  # deaf for as long as that
                    rclpy.spin_once(node, timeout_sec=0.0)
            while not limits.complaint(3e-3) and time.monotonic() < end:
                rclpy.spin_once(client, timeout_sec=0.05)
            assert len(asked) >= 2
            assert limits.complaint(3e-3).startswith('0.003 A is outside the current_limits of ')
            assert not limits.awaited(time.monotonic())
        finally:
            client.destroy_node()
            node.destroy_node()


@pytest.mark.parametrize('value', [None, 3, 'high', [0.0], [0.0, 1.0, 2.0], ['a', 'b'], True])
def test_what_is_no_pair_of_numbers_limits_no_current(value):
    limits = CurrentLimits(None)
    limits.take('driver', value)
    assert limits.complaint(1e9) == ''
    limits.take('positioner', [0.0, 2e-3])
    assert limits.complaint(2e-3) == ''
    assert 'current_limits of positioner' in limits.complaint(2.1e-3)
