# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why a run of many cannot go on."""


class RunError(Exception):
    """A run cannot go on; the message is one sentence for the user."""
