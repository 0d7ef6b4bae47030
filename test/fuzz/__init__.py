# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Inputs that nobody would write: each reader, preparing and the plant must answer them."""
