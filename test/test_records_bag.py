# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bags: topics become columns on one time base, whatever their types, names and stamps."""

from collections.abc import Callable, Iterable
from pathlib import Path
import re
import resource
import sys

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer
from rosbags.typesys import Stores, get_typestore

from booster_ros.records import RecordError, bag_limits, read_record
from booster_ros.records.bag_writer import STORAGE, BagWriter
from booster_ros.records.recording import Recording
from booster_ros.records.time_base import Signal, merge, to_nearest_rows

STORE = get_typestore(Stores.ROS2_JAZZY)
START = 1_700_000_000_000_000_000
TICK = 10_000_000
ATMOSPHERE = 101_325.0

Message = tuple[str, str, int, object]


def kind(name: str) -> Callable[..., object]:
    return STORE.types[name]


def float64(topic: str, value: float, stamp: int) -> Message:
    name = 'std_msgs/msg/Float64'
    return topic, name, stamp, kind(name)(data=value)


def header(stamp: int) -> object:
    time = kind('builtin_interfaces/msg/Time')(sec=stamp // 10**9, nanosec=stamp % 10**9)
    return kind('std_msgs/msg/Header')(stamp=time, frame_id='positioner')


def fluid_pressure(topic: str, gauge: float, stamp: int, sampled: int) -> Message:
    name = 'sensor_msgs/msg/FluidPressure'
    message = kind(name)(
        header=header(sampled), fluid_pressure=gauge + ATMOSPHERE, variance=0.0)
    return topic, name, stamp, message


def joint_state(
    topic: str, stamp: int, sampled: int, **positions: float
) -> Message:
    name = 'sensor_msgs/msg/JointState'
    empty = np.array([])
    message = kind(name)(
        header=header(sampled), name=list(positions),
        position=np.array(list(positions.values())), velocity=empty, effort=empty)
    return topic, name, stamp, message


def state(topic: str, stamp: int, **values: float) -> Message:
    name = 'diagnostic_msgs/msg/DiagnosticArray'
    pair = kind('diagnostic_msgs/msg/KeyValue')
    status = kind('diagnostic_msgs/msg/DiagnosticStatus')(
        level=0, name='state', message='', hardware_id='',
        values=[pair(key=key, value=repr(value)) for key, value in values.items()])
    return topic, name, stamp, kind(name)(header=header(stamp), status=[status])


def write_bag(
    path: Path, messages: Iterable[Message], storage: str = 'mcap', compressed: bool = False
) -> Path:
    writer = Writer(path, version=9, storage_plugin=STORAGE[storage])
    if compressed:
        writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, name, stamp, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=STORE)
            writer.write(connections[topic], stamp, STORE.serialize_cdr(message, name))
    return path


def plain_messages(count: int = 100, namespace: str = '') -> list[Message]:
    """Return outputs every tick, the position 2 ms after the pressure, and a step of current."""
    messages = []
    for tick in range(count):
        stamp = START + tick * TICK
        current = 4e-4 if tick < 50 else 3e-4
        messages += [
            float64(f'{namespace}/control_current', current, stamp + 3_000_000),
            float64(f'{namespace}/chamber_pressure', 150_000.0 + 100 * tick, stamp),
            float64(f'{namespace}/valve_position', 0.001 + 1e-6 * tick, stamp + 2_000_000),
        ]
    return messages


def kinds(record) -> list[str]:
    return [defect.kind for defect in record.defects]


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
@pytest.mark.parametrize('name', ['record', 'record.bag'])
def test_topics_become_columns_on_one_time_base(tmp_path, storage, name):
    record = read_record(write_bag(tmp_path / name, plain_messages(), storage))
    assert set(record.columns) == {
        'time', 'control_current', 'chamber_pressure', 'valve_position'}
    np.testing.assert_allclose(record['time'], np.arange(100) / 100, atol=1e-9)
    # The samples of the time base stay as they are …
    np.testing.assert_array_equal(record['chamber_pressure'], 150_000.0 + 100 * np.arange(100))
    # … those of the other signal are carried 2 ms back along their slope …
    np.testing.assert_allclose(
        record['valve_position'], 0.001 + 1e-6 * (np.arange(100) - 0.2), rtol=1e-9)
    # … and the command that was sent 3 ms after a sample counts from there on.
    np.testing.assert_array_equal(
        record['control_current'], np.where(np.arange(100) < 50, 4e-4, 3e-4))
    assert kinds(record)[0] == 'time_base'
    assert '/chamber_pressure' in record.notes[0]


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_the_file_in_a_bag_reads_as_the_bag(tmp_path, storage):
    bag = write_bag(tmp_path / 'record', plain_messages(), storage)
    (file,) = (path for path in bag.iterdir() if path.suffix in ('.mcap', '.db3'))
    np.testing.assert_array_equal(read_record(file)['time'], read_record(bag)['time'])


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_compressed_bag_reads_the_same(tmp_path, storage):
    plain = read_record(write_bag(tmp_path / 'plain', plain_messages(), storage))
    record = read_record(write_bag(tmp_path / 'zstd', plain_messages(), storage, compressed=True))
    np.testing.assert_array_equal(record['chamber_pressure'], plain['chamber_pressure'])


def test_a_command_counts_for_the_row_that_it_covers_for_longer(tmp_path):
    messages = [  # the step is sent 6 ms after the sample of tick 50
        (topic, name, stamp + 3_000_000 * ('current' in topic), message)
        for topic, name, stamp, message in plain_messages()
    ]
    record = read_record(write_bag(tmp_path / 'record', messages))
    first = np.flatnonzero(record['control_current'] == 3e-4)[0]
    assert record['time'][first] == pytest.approx(0.51)


def test_a_bag_without_the_library_that_reads_it_is_refused_by_name(tmp_path, monkeypatch):
    bag = write_bag(tmp_path / 'record', plain_messages())
    monkeypatch.delitem(sys.modules, 'booster_ros.records.bag_reader', raising=False)
    monkeypatch.setitem(sys.modules, 'rosbags.rosbag2', None)
    with pytest.raises(RecordError, match=r'record: reading a bag needs .* rosbags'):
        read_record(bag)


def test_a_slower_signal_counts_in_the_rows_nearest_to_its_samples_only(tmp_path):
    messages = [message for k, message in enumerate(plain_messages())
                if 'position' not in message[0] or (k // 3) % 5 == 0]
    record = read_record(write_bag(tmp_path / 'record', messages))
    known = np.flatnonzero(np.isfinite(record['valve_position']))
    np.testing.assert_array_equal(known, np.arange(0, 100, 5))
    np.testing.assert_allclose(
        record['valve_position'][known], 0.001 + 1e-6 * (known - 0.2), rtol=1e-9)


def test_a_signal_at_other_times_keeps_its_noise(tmp_path):
    """Interpolated half way between two samples it would have 0.7 of it."""
    rng = np.random.default_rng(1)
    time, between = np.arange(2000) / 100, np.arange(1999) / 100 + 0.005
    columns, _, _ = merge({
        'valve_position': Signal('/x', time, np.zeros(2000)),
        'chamber_pressure': Signal('/p', between, 4e3 * between + rng.standard_normal(1999))})
    left = (columns['chamber_pressure'] - 4e3 * time)[2:-3]
    assert np.isfinite(left).all()
    assert abs(np.mean(left)) < 0.1
    assert np.std(left) == pytest.approx(1.0, abs=0.06)


def test_of_two_samples_in_one_row_the_nearer_counts():
    time = np.arange(20) / 100
    for late in (0.001, -0.001):  # the nearer one comes first, or last
        at = np.sort(np.concatenate([time - 0.003 * np.sign(late), time + late]))
        values = np.where(np.isin(at, time + late), 1.0, 0.0)
        assert to_nearest_rows(Signal('/p', at, values), time)[2:-2] == pytest.approx(1.0)


def test_a_signal_has_no_rows_in_its_gap(tmp_path):
    messages = [
        message for message in plain_messages()
        if not ('position' in message[0] and START + 30 * TICK < message[2] < START + 60 * TICK)
    ]
    record = read_record(write_bag(tmp_path / 'record', messages))
    missing = np.flatnonzero(np.isnan(record['valve_position']))
    np.testing.assert_array_equal(missing, np.arange(30, 60))
    assert 'missing_values' in kinds(record)


def test_rows_before_the_first_command_are_dropped(tmp_path):
    messages = [
        message for message in plain_messages()
        if 'current' not in message[0] or message[2] > START + 20 * TICK
    ]
    record = read_record(write_bag(tmp_path / 'record', messages))
    assert len(record) == 80
    assert record.rows[0] == 21
    assert any('before the first message of control_current' in note for note in record.notes)


def test_one_namespace_needs_no_mapping_and_two_do(tmp_path):
    one = write_bag(tmp_path / 'one', plain_messages(namespace='/plant/valve_7'))
    assert 'chamber_pressure' in read_record(one)
    two = write_bag(
        tmp_path / 'two', plain_messages(namespace='/left') + plain_messages(namespace='/right'))
    with pytest.raises(RecordError) as refusal:
        read_record(two)
    assert 'control_current could be /left/control_current or /right/control_current' in str(
        refusal.value)
    topics = {
        column: f'/right/{column}'
        for column in ('control_current', 'chamber_pressure', 'valve_position')}
    assert '/right/chamber_pressure' in read_record(two, topics).notes[0]


def stamped_messages(count: int = 100) -> list[Message]:
    """Return outputs that are sampled at ticks and arrive between 0 and 5 ms later."""
    random = np.random.default_rng(1)
    messages = []
    for tick in range(count):
        sampled = START + tick * TICK
        arrival = sampled + int(random.integers(0, 5_000_000))
        messages += [
            float64('/control_current', 4e-4, sampled),
            float64('/chamber_pressure', 100.0 * tick, arrival),
            fluid_pressure('/chamber_pressure_stamped', 100.0 * tick, arrival, sampled),
            joint_state('/valve_position_stamped', arrival, sampled, valve_stem=1e-6 * tick),
        ]
    return messages


def test_header_time_does_not_depend_on_arrival_and_pressure_becomes_gauge(tmp_path):
    bag = write_bag(tmp_path / 'record', stamped_messages())
    record = read_record(bag, stamps='header')
    np.testing.assert_allclose(np.diff(record['time']), 0.01, atol=1e-9)
    np.testing.assert_allclose(record['chamber_pressure'], 100.0 * np.arange(100), atol=1e-9)
    np.testing.assert_allclose(record['valve_position'], 1e-6 * np.arange(100), atol=1e-15)
    assert np.ptp(np.diff(read_record(bag)['time'])) > 1e-3


@pytest.mark.parametrize(('messages', 'says'), [
    (plain_messages(), 'no topic has stamps in its header'),
    ([fluid_pressure('/chamber_pressure', 1e5, START + k * TICK, START + abs(k - 4) * -TICK)
      for k in range(9)], 'header stamps of topic /chamber_pressure run backwards at message 6'),
    ([message for k in range(9) for message in (
        fluid_pressure('/chamber_pressure', 1e5, START + k * TICK, 10**9 + k * TICK),
        float64('/control_current', 4e-4, START + k * TICK))],
     'topic /control_current has no header, and the header stamps of /chamber_pressure are of '
     'another clock'),
], ids=['no header', 'backwards', 'two clocks'])
def test_header_time_is_refused(tmp_path, messages, says):
    with pytest.raises(RecordError, match=says):
        read_record(write_bag(tmp_path / 'record', messages), stamps='header')


def test_a_joint_is_asked_for_by_name(tmp_path):
    messages = [
        joint_state('/joint_states', START + k * TICK, START + k * TICK, elbow=0.1, valve=k * 1e-4)
        for k in range(20)]
    bag = write_bag(tmp_path / 'record', messages)
    record = read_record(bag, {'valve_position': '/joint_states:valve'})
    np.testing.assert_allclose(record['valve_position'], np.arange(20) * 1e-4)
    with pytest.raises(RecordError, match='joint_states names elbow, valve; say which'):
        read_record(bag, {'valve_position': '/joint_states'})


def test_joints_that_share_a_topic_are_told_apart_or_refused(tmp_path):
    messages = [joint_state('/joint_states', START + at, START + at, **{name: position})
                for tick in range(20) for at, name, position in (
                    (tick * TICK, 'gripper', 0.5), (tick * TICK + TICK // 2, 'valve', 1e-4 * tick))]
    bag = write_bag(tmp_path / 'shared', messages)
    record = read_record(bag, {'valve_position': '/joint_states:valve'})
    assert record['valve_position'] == pytest.approx(1e-4 * np.arange(20))
    for asked in ('/joint_states', '/joint_states:stem'):
        with pytest.raises(RecordError, match='names gripper, valve; say which is valve_position'):
            read_record(bag, {'valve_position': asked})


def test_the_state_of_a_positioner_fills_the_columns_without_a_topic(tmp_path):
    messages = []
    for tick in range(20):
        stamp = START + tick * TICK
        messages += [
            float64('/chamber_pressure', 5e3 + tick, stamp),
            state(
                '/positioner/state', stamp, control_current=1e-5 * tick, back_pressure=2e5 + tick,
                supply_pressure=4e5, mass_flow=1e-6 * tick, measured_chamber_pressure=-1.0,
                chamber_pressure=-1.0, measured_valve_position=1e-4 * tick, valve_position=-1.0),
        ]
    bag = write_bag(tmp_path / 'record', messages)
    record = read_record(bag)
    np.testing.assert_array_equal(record['chamber_pressure'], 5e3 + np.arange(20))
    np.testing.assert_array_equal(record['back_pressure'], 2e5 + np.arange(20))
    np.testing.assert_allclose(record['valve_position'], 1e-4 * np.arange(20))
    # The state names the current that led to it: it belongs to the row before.
    np.testing.assert_allclose(record['control_current'][:19], 1e-5 * np.arange(1, 20))
    asked = {'valve_position': '/positioner/state', 'back_pressure': '/positioner/state:mass_flow'}
    record = read_record(bag, asked)
    np.testing.assert_allclose(record['valve_position'], 1e-4 * np.arange(20))
    np.testing.assert_allclose(record['back_pressure'], 1e-6 * np.arange(20))


@pytest.mark.parametrize(('messages', 'topics', 'says'), [
    ([float64('/pressure', 1.0, START)], None, 'no topic is called after a column; there are /p'),
    (plain_messages(), {'chamber_pressure': '/p'}, 'topic /p for column chamber_pressure is not'),
    (plain_messages(), {'chamber': '/p'}, "topics: 'chamber' is not a column"),
    ([('/valve_position', 'std_msgs/msg/Header', START, header(START))],
     {'valve_position': '/valve_position'}, 'is of type std_msgs/msg/Header, not one of'),
    ([float64('/control_current', 0.45, START + k) for k in range(9)], None,
     'row 1, column control_current: 0.45 is not plausible in A'),
    ([float64('/valve_position', np.inf, START + k) for k in range(9)], None, 'is infinite'),
    ([state('/positioner/state', START, **dict.fromkeys(
        ('control_current', 'back_pressure', 'supply_pressure', 'mass_flow',
         'measured_chamber_pressure', 'measured_valve_position'), 1e-3))], None,
     'topic /positioner/state has one message'),
])
def test_refusals(tmp_path, messages, topics, says):
    with pytest.raises(RecordError, match=re.escape(says)):
        read_record(write_bag(tmp_path / 'record', messages), topics)


def test_an_incomplete_or_damaged_bag_is_refused_in_a_sentence(tmp_path):
    bag = write_bag(tmp_path / 'record', plain_messages())
    content = (bag / 'record.mcap').read_bytes()
    for size in (0, 5, 100, len(content) // 2, len(content) - 9):
        (bag / 'record.mcap').write_bytes(content[:size])
        with pytest.raises(RecordError, match='not a readable bag') as refusal:
            read_record(bag)
        assert '\n' not in str(refusal.value)
    (bag / 'metadata.yaml').unlink()
    with pytest.raises(RecordError, match=r'has no metadata\.yaml.*ros2 bag reindex'):
        read_record(bag)


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_written_bag_appears_complete_or_not_at_all(tmp_path, storage):
    path = tmp_path / 'record'
    with BagWriter(path, ['/left/chamber_pressure'], storage) as writer:
        for tick in range(20):
            writer.write('/left/chamber_pressure', 5e5 + tick, START + tick * TICK)
        assert not path.exists()
    np.testing.assert_array_equal(read_record(path)['chamber_pressure'], 5e5 + np.arange(20))
    assert [entry.name for entry in tmp_path.iterdir()] == ['record']
    link = tmp_path / 'link'
    link.symlink_to(tmp_path / 'nothing')
    for there in (path, link):
        with pytest.raises(RecordError, match='exists already'):
            BagWriter(there, [], storage)


def test_an_interrupted_bag_leaves_nothing(tmp_path):
    def interrupted() -> None:
        with BagWriter(tmp_path / 'record', ['/x'], 'mcap') as writer:
            writer.write('/x', 1.0, START)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not list(tmp_path.iterdir())


def test_the_tools_of_mcap_read_a_written_bag(tmp_path):
    reader = pytest.importorskip('mcap_ros2.reader')
    with BagWriter(tmp_path / 'record', ['/chamber_pressure'], 'mcap') as writer:
        for tick in range(20):
            writer.write('/chamber_pressure', 5e3 + tick, START + tick * TICK)
    messages = list(reader.read_ros2_messages(str(tmp_path / 'record' / 'record.mcap')))
    assert [message.ros_msg.data for message in messages] == [5e3 + tick for tick in range(20)]
    assert {message.channel.topic for message in messages} == {'/chamber_pressure'}


ALIASES = 'a0: &a0 [x, x]\n' + ''.join(
    f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * 9)}]\n' for k in range(1, 30))


@pytest.mark.parametrize(('text', 'says'), [
    (ALIASES, r'metadata\.yaml has an alias \(\*name\) in line 2'),
    ('x' * 2_000_001, r'metadata\.yaml has more than 2000000 bytes'),
], ids=['aliases', 'bytes'])
def test_metadata_that_no_recorder_writes_are_refused(tmp_path, text, says):
    bag = write_bag(tmp_path / 'record', plain_messages())
    (bag / 'metadata.yaml').write_text(text)
    with pytest.raises(RecordError, match=says):
        read_record(bag)


def packed_bag(path: Path, mode: CompressionMode, storage: str, size: int) -> Path:
    """Return a compressed bag in which a message has so many bytes more than it needs."""
    packed = Writer(path, version=Writer.VERSION_LATEST,
                    storage_plugin=STORAGE[storage])
    packed.set_compression(mode, CompressionFormat.ZSTD)
    kind_of = 'std_msgs/msg/Float64'
    with packed as bag:
        topic = bag.add_connection('/chamber_pressure', kind_of, typestore=STORE)
        data = bytes(STORE.serialize_cdr(kind(kind_of)(data=2e5), kind_of))
        for tick in range(20):
            bag.write(topic, START + tick * TICK, data + bytes(size))
    return path


@pytest.mark.parametrize(('mode', 'storage', 'says'), [
    (CompressionMode.MESSAGE, 'sqlite3', 'a compressed message of .* once it is unpacked'),
    (CompressionMode.MESSAGE, 'mcap', 'a compressed message of .* once it is unpacked'),
    (CompressionMode.STORAGE, 'mcap', 'a compressed chunk of .* once it is unpacked'),
    (CompressionMode.FILE, 'sqlite3', 'is too large once it is unpacked'),
])
def test_a_few_bytes_do_not_become_gigabytes(tmp_path, monkeypatch, mode, storage, says):
    monkeypatch.setattr(bag_limits, 'LARGEST_MESSAGE', 10_000)
    monkeypatch.setattr(bag_limits, 'LARGEST_CHUNK', 10_000)
    monkeypatch.setattr(bag_limits, 'LARGEST_RATIO', 2)
    monkeypatch.setattr(bag_limits, '_PIECE', 1000)
    small = packed_bag(tmp_path / 'small', mode, storage, 0)
    if mode != CompressionMode.FILE:
        assert len(read_record(small)) == 20
    with pytest.raises(RecordError, match=says):
        read_record(packed_bag(tmp_path / 'large', mode, storage, 20_000))


def test_a_compressed_message_that_is_cut_short_is_refused():
    packed = bag_limits.zstd.compress(b'x' * 1000)
    assert bag_limits.unpacked_message(packed) == b'x' * 1000
    with pytest.raises(RecordError, match='cut short'):
        bag_limits.unpacked_message(packed[:-5])


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_bag_on_a_full_disk_is_refused_and_nothing_is_left(tmp_path, storage):
    def fill():
        with BagWriter(tmp_path / 'record', ['/chamber_pressure'], storage) as writer:
            for tick in range(10_000):
                writer.write('/chamber_pressure', 1.0, START + tick)

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, limits[1]))
    try:
        with pytest.raises(RecordError, match='record cannot be written: '):
            fill()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == []


def test_without_what_writes_bags_it_is_said_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'booster_ros.records.bag_writer', None)
    with pytest.raises(RecordError, match=r'record: writing a bag needs .* pip install rosbags'):
        Recording(str(tmp_path / 'out.csv'), str(tmp_path / 'record'), 'mcap', {})
    assert list(tmp_path.iterdir()) == []
