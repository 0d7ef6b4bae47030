# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Faults by name: when they are on, how strong they are, and what they do; without ROS."""
