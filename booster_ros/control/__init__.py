# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a controller does, without ROS: profiles to play, and the position loop."""
