# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the paper printed, and the calculations with which it judged its model."""
