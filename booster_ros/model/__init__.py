# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Physics of the positioner: no ROS, no files, no printing."""
