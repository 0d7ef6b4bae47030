# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the residual of a record to the effect that the model lacks."""
