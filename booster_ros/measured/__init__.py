# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What `close_loop` finds in measurements by others, and the page that shows it."""
