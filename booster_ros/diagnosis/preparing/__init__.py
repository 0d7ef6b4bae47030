# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a record to an experiment: what may be compared, where it starts, when a command came."""
