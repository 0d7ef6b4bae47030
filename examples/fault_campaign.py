# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A controller against every fault at three strengths: what it leaves of the error, as CSV."""

import csv
import sys

from pi_controller import PiController

from booster_ros.testing.valve import Valve

FAULTS = (
    'stem_friction', 'chamber_leak', 'supply_loss', 'booster_dead_band', 'position_sensor_stuck',
    'position_sensor_noise', 'pressure_sensor_noise', 'bench_set_shift',
)
STRENGTHS = ('small', 'medium', 'big')
BEFORE, AFTER = 0.006, 0.010
"""Set points before and after the fault, m."""

SETTLING, JUDGED = 30.0, 5.0
"""Seconds for a move, and those at its end in which the error counts."""


def error_after(fault, strength):
    """Return the largest error, m, at the end of a move that a fault disturbs."""
    with Valve() as valve:
        controller = PiController(valve.context)
        valve.add(controller)
        controller.set_point = BEFORE
        valve.settle()
        if fault:
            valve.inject(fault, strength=strength)
        controller.set_point = AFTER
        moved = valve.run(SETTLING)
        judged = moved.since(moved.last.time - JUDGED)
        return float(abs(judged['valve_position'] - AFTER).max())


def main():
    """Print a line for each fault and strength, the first without a fault."""
    table = csv.writer(sys.stdout)
    table.writerow(('fault', 'strength', 'largest error, m'))
    table.writerow(('none', '', f'{error_after(None, None):.6f}'))
    for fault in FAULTS:
        for strength in STRENGTHS:
            table.writerow((fault, strength, f'{error_after(fault, strength):.6f}'))
            sys.stdout.flush()


if __name__ == '__main__':
    main()
