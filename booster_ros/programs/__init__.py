# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command-line programs: arguments, progress and printing around the packages beside them."""
