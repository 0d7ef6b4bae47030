# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Colours of all figures, told apart by colour-blind eyes and in grey print (Okabe and Ito)."""

MEASURED = '#3a3a3a'
BEFORE = '#d55e00'
AFTER = '#0072b2'
NOISE = '#9a9a9a'
LOCKED = '#eef1f4'
INK = '#222222'
GRID = '#e4e4e4'
ROLE_SHADES = {'train': '#dfe5ea', 'test': '#6f8090'}
