# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Diagnose the valves of a plant side by side, and say which need attention."""
