# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A ROS domain that no other process on this machine is using."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import random
import socket

# Above 101 the ports of a domain fall into Linux's ephemeral range.
DOMAINS = range(1, 102)
# One TCP port a domain, below the ephemeral range: whoever has it bound owns the domain.
_FIRST_CLAIM_PORT = 21600
# DDS: port base 7400, domain gain 250; +10 is the first participant's own port.
_FIRST_PARTICIPANT_PORT = 7410
_PORTS_PER_DOMAIN = 250


@dataclass(frozen=True)
class ClaimedDomain:
    """A domain id, ours until `release` or the end of the process."""

    id: int
    claim: socket.socket

    def release(self) -> None:
        """Give the domain back."""
        self.claim.close()


def claim_domain(among: Sequence[int] = DOMAINS) -> ClaimedDomain:
    """
    Claim a domain, one of `among`, in which nobody listens and which no other claimer has.

    Claims are bound ports, which the kernel frees when a process ends however it ends.

    Raises:
        RuntimeError: all of them are taken.

    """
    for domain in random.sample(among, len(among)):
        claim = _bind(socket.SOCK_STREAM, _FIRST_CLAIM_PORT + domain)
        if claim is None:
            continue
        participant = _bind(socket.SOCK_DGRAM, _FIRST_PARTICIPANT_PORT + _PORTS_PER_DOMAIN * domain)
        if participant is None:
            claim.close()
            continue
        participant.close()
        return ClaimedDomain(domain, claim)
    raise RuntimeError(f'the ROS domains {min(among)} to {max(among)} are all in use here')


def _bind(kind: socket.SocketKind, port: int) -> socket.socket | None:
    """Return a socket bound to the port, or None where somebody else has it."""
    bound = socket.socket(socket.AF_INET, kind)
    try:
        bound.bind(('', port))
    except OSError:
        bound.close()
        return None
    return bound
