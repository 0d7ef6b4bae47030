# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The search for what the model lacks: effects with a name, and terms without one."""
