# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a control valve from a record of set point and position alone, without a model."""
