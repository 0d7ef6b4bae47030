# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files and folders that take their place when they are complete, and not before."""
