# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 nodes and what they are made of."""
