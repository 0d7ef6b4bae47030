# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How exact the model's solver is: the cases, and a reference solution made by scipy."""
