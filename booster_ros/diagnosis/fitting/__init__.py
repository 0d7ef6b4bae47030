# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fits of the model to an experiment: what they may turn, how they are made, how sure they are."""
