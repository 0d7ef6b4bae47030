# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ends a run that began with good input, in a node or a program."""


class RunError(RuntimeError):
    """A run cannot go on; the message is one sentence that says why."""
