# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Health in the five words of NAMUR NE 107, each with its reason in a sentence."""

from typing import NamedTuple

FAILURE = 'failure'
FUNCTION_CHECK = 'function check'
OUT_OF_SPECIFICATION = 'out of specification'
MAINTENANCE = 'maintenance required'
GOOD = 'good'


class Health(NamedTuple):
    """A status signal of NE 107 and the reason for it."""

    status: str
    reason: str


def health(silent: list[str], alarms: list[str], beyond: list[str], lacking: str) -> Health:
    """
    Return the worst that holds.

    `silent` are channels that no longer come, `alarms` sentences on what has changed, `beyond`
    what cannot be of the valve that was learnt, `lacking` what keeps the twin from judging.
    """
    if silent:
        return Health(FAILURE, f'nothing comes any more of {" and ".join(silent)}')
    if beyond:
        return Health(OUT_OF_SPECIFICATION, '; '.join(beyond))
    if alarms:
        return Health(MAINTENANCE, '; '.join(alarms))
    if lacking:
        return Health(FUNCTION_CHECK, lacking)
    return Health(GOOD, 'the valve does what its model says, within the declared drift')
