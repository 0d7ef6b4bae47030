# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often 95 % intervals hold the truth, and how near the noise comes to what it is."""
