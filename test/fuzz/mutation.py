# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files changed at random: bytes turned, lines lost, doubled or exchanged, odd words put in."""

from __future__ import annotations

import random

WORDS = (
    b'', b'nan', b'inf', b'-1e308', b'1e-320', b'1_000', b'0x10', b'"', b'""', b"'", b';', b'\t',
    b'\r', b'\r\n', b'\n\n', b'\x00', b'\xff\xfe', b'\xef\xbb\xbf', b'\xa0', b'\x85', b'\x1c',
    b'time', b'*a', b'&a', b'!!int', b'{', b'}', b'[', b']', b'- ', b'? ', b': ', b'#', b'%', b',',
    b',,', b'.', b'1e', b'+', b'-', b'9' * 400, b'_' * 3000, b'(Pa)', b'/**:', b'\xf0\x9f\x92\xa9',
)
MOST_CHANGES = 8


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Return data with some changes."""
    for _ in range(rng.randint(1, MOST_CHANGES)):
        data = rng.choice((_turned, _put_in, _cut, _lines))(data, rng)
    return data


def _turned(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return data
    place = rng.randrange(len(data))
    return data[:place] + bytes([rng.randrange(256)]) + data[place + 1:]


def _put_in(data: bytes, rng: random.Random) -> bytes:
    place = rng.randint(0, len(data))
    gone = rng.choice((0, 0, 1, 5))
    return data[:place] + rng.choice(WORDS) + data[place + gone:]


def _cut(data: bytes, rng: random.Random) -> bytes:
    first, last = sorted(rng.randint(0, len(data)) for _ in range(2))
    if rng.random() < 0.7:
        last = min(last, first + 20)
    return data[:first] + data[last:]


def _lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b'\n')
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    way = rng.random()
    if way < 0.4:
        lines[one], lines[other] = lines[other], lines[one]
    elif way < 0.7:
        lines.insert(one, lines[other])
    else:
        del lines[one]
    return b'\n'.join(lines)
