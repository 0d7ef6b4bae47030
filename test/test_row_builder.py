# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a recording: outputs that belong together, with the current that followed them."""

from math import isnan

from booster_ros.records.row_builder import Row, RowBuilder


def play(*events: tuple) -> list[Row]:
    """Return the rows made of ('i', A), ('p', Pa, s) and ('x', m, s)."""
    builder = RowBuilder()
    rows = []
    for name, value, *time in events:
        if name == 'i':
            builder.sent(value)
        else:
            column = {'p': 'chamber_pressure', 'x': 'valve_position'}[name]
            rows.append(builder.received(column, value, *time))
    return [row for row in [*rows, builder.last()] if row is not None]


def test_a_row_has_the_current_that_drives_from_it_to_the_next():
    assert play(
        ('i', 1.0), ('p', 10.0, 0.0), ('x', 20.0, 0.001), ('i', 2.0),
        ('p', 11.0, 0.1), ('x', 21.0, 0.101), ('i', 3.0),
    ) == [Row(0.0, 2.0, 10.0, 20.0), Row(0.1, 3.0, 11.0, 21.0)]


def test_either_output_may_come_first():
    rows = play(
        ('i', 1.0), ('x', 20.0, 0.0), ('p', 10.0, 0.0), ('x', 21.0, 0.1), ('p', 11.0, 0.1))
    assert rows == [Row(0.0, 1.0, 10.0, 20.0), Row(0.1, 1.0, 11.0, 21.0)]


def test_a_lost_message_leaves_a_hole_and_no_shift():
    events = [('i', 1.0)]
    for tick in range(5):
        events.append(('p', 10.0 + tick, tick / 10))
        events.append(('x', 20.0 + tick, tick / 10 + 0.001))
    del events[5]  # a pressure
    rows = play(*events)
    assert [row.valve_position for row in rows] == [20.0, 21.0, 22.0, 23.0, 24.0]
    assert isnan(rows[2].chamber_pressure)
    assert [row.chamber_pressure for row in rows[3:]] == [13.0, 14.0]


def test_before_the_first_command_the_current_is_unknown():
    rows = play(('p', 10.0, 0.0), ('x', 20.0, 0.0), ('p', 11.0, 0.1), ('i', 1.0))
    assert isnan(rows[0].control_current)
    assert rows[1].control_current == 1.0
