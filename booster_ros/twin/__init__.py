# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The live twin: the model beside the real valve, and alarms with a promised rate."""
