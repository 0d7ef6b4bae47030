# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a recording: outputs that belong together, with the current that followed them."""

from math import isnan

from booster_ros.records.row_builder import Row, RowBuilder

COLUMNS = {'p': 'chamber_pressure', 'x': 'valve_position'}


def play(*events: tuple[str, float, float]) -> list[Row]:
    """Return the rows made of ('i', A, s), ('p', Pa, s) and ('x', m, s), in order of arrival."""
    builder = RowBuilder()
    rows = []
    for name, value, time in events:
        if name == 'i':
            builder.sent(value, time)
        else:
            rows += builder.received(COLUMNS[name], value, time)
    return rows + builder.rest()


def samples(count: int, offset: float = 0.001) -> list[tuple[str, float, float]]:
    """Return a command, then pressures and positions every 0.1 s, the latter `offset` later."""
    events = [('i', 1.0, 0.0)]
    for tick in range(count):
        events.append(('p', 10.0 + tick, tick / 10))
        events.append(('x', 20.0 + tick, tick / 10 + offset))
    return events


def test_a_row_has_the_current_that_drives_from_it_to_the_next():
    assert play(
        ('i', 1.0, 0.0), ('p', 10.0, 0.0), ('x', 20.0, 0.0), ('i', 2.0, 0.03),
        ('p', 11.0, 0.1), ('x', 21.0, 0.1), ('i', 3.0, 0.13),
    ) == [Row(0.0, 2.0, 10.0, 20.0), Row(0.1, 3.0, 11.0, 21.0)]


def test_times_decide_and_not_arrival():
    """The sample at 0.1 arrives when the command of 0.13 has been sent already."""
    rows = play(
        ('i', 1.0, 0.0), ('p', 10.0, 0.0), ('x', 20.0, 0.0), ('i', 2.0, 0.03),
        ('i', 3.0, 0.13), ('p', 11.0, 0.1), ('x', 21.0, 0.1))
    assert rows == [Row(0.0, 2.0, 10.0, 20.0), Row(0.1, 3.0, 11.0, 21.0)]


def test_either_output_may_come_first():
    rows = play(
        ('i', 1.0, 0.0), ('x', 20.0, 0.0), ('p', 10.0, 0.0), ('x', 21.0, 0.1), ('p', 11.0, 0.1))
    assert rows == [Row(0.0, 1.0, 10.0, 20.0), Row(0.1, 1.0, 11.0, 21.0)]


def test_outputs_that_overtake_each_other_stay_with_their_samples():
    events = samples(10, offset=0.0)
    # The pressures of samples 4 and 5 come before their positions.
    assert events[10][0] == 'x'
    events[10], events[11] = events[11], events[10]
    assert play(*events) == play(*samples(10, offset=0.0))


def test_an_output_that_is_late_by_most_of_a_period_stays_with_its_sample():
    events = samples(8)
    late = events.index(('x', 23.0, 0.301))
    events[late] = ('x', 23.0, 0.37)
    assert play(*events) == play(*samples(8))


def test_a_lost_message_leaves_a_hole_and_no_shift():
    events = samples(8)
    lost = events.pop(5)
    assert lost[:2] == ('p', 12.0)
    rows = play(*events)
    assert [row.valve_position for row in rows] == [20.0 + tick for tick in range(8)]
    assert isnan(rows[2].chamber_pressure)
    assert [row.chamber_pressure for row in rows[3:]] == [13.0 + tick for tick in range(5)]


def test_one_output_alone_makes_rows_too():
    rows = play(*(event for event in samples(8) if event[0] != 'p'))
    assert [row.valve_position for row in rows] == [20.0 + tick for tick in range(8)]


def test_before_the_first_command_the_current_is_unknown():
    rows = play(('p', 10.0, 0.0), ('x', 20.0, 0.0), ('p', 11.0, 0.1), ('i', 1.0, 0.13))
    assert isnan(rows[0].control_current)
    assert rows[1].control_current == 1.0
