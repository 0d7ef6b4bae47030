# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Campaigns: the diagnosis judged on sets of records whose truth is known, and two states compared.

The diagnosis is run as a program and read from what it writes. Nothing here imports it, so one
state of the package can judge another.
"""
