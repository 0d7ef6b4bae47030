# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A second valve positioner, written apart from `booster_ros.model`, that plays the real valve.

It shares the declared equations with the model and nothing else: gas is counted in kilograms
instead of pascals, time is stepped at 20 µs, end stops are stiff springs, friction sticks by an
event. It can put in effects that the model's catalogue has, and some that it has not, and writes
the records a test engineer would bring: `CASE.yaml` (what the name plate says), `CASE_fit.csv`,
`CASE_val.csv` and `key.json` (what was hidden). Only numpy and numba are needed; `confusion`, which
runs `close_loop` on such records, needs more.
"""
