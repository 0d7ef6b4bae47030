# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated electro-pneumatic valve positioner, and the search for what its model lacks."""
