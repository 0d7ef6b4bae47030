# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in files: for programs (JSON), for people (one HTML page) and for the node (YAML)."""
