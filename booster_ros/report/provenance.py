# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a diagnosis is from."""

from typing import NamedTuple


class Provenance(NamedTuple):
    """The files that a diagnosis was made from, as the user named them; '' for none."""

    record: str
    parameters: str
    validation: str = ''
