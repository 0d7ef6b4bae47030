# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
