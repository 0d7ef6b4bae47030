# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a record says: what drives the model, what is compared with it, and how noisy that is."""
