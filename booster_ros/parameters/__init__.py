# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All parameters of the package in one table, and the files they are written in."""
