# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The confusion matrix of `close_loop`: what it says of every effect, at every size and noise.

Each cell is a record of the hidden plant, with a second one for validation, and a run of the
program as anyone would start it. Beside numpy and numba this needs scipy and matplotlib.
"""
