# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Texts of others, such as names of files and columns, as they may be shown and written."""

import os
import unicodedata

_NOT_SHOWN = frozenset(('Cc', 'Cf', 'Cs', 'Zl', 'Zp'))
"""Categories of Unicode: controls and formats, halves of pairs, separators of lines."""


def legible(text: str | os.PathLike[str]) -> str:
    r"""
    Return a text, or a path, on one line and without what a terminal would obey.

    Bytes of a path that are no UTF-8 become replacement characters.

    >>> legible('a\nb\x1b[2J')
    'a\\nb\\x1b[2J'
    """
    decoded = os.fsencode(text).decode('utf-8', 'replace') if _is_encodable(text) else str(text)
    return ''.join(
        character.encode('unicode_escape').decode()
        if unicodedata.category(character) in _NOT_SHOWN else character for character in decoded)


def _is_encodable(text: str | os.PathLike[str]) -> bool:
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        return False
    return True
