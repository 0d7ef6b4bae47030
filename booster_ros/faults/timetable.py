# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Timetables of faults: a list in YAML, as a text or in a file."""

from collections.abc import Sequence
from pathlib import Path
import re
from typing import Any

import yaml

from ..model.parameters import ParameterError, shown
from .injection import Injection, injection

LARGEST = 1_000_000
"""Characters of a timetable at most."""


def read_timetable(text: str, source: str = 'the timetable') -> list[Injection]:
    """
    Return the injections of a timetable; an empty text is none.

    It is a list of injections, or a single one. Numbers are read as ROS 2 reads them: `1e-3` is
    one. ParameterError, one sentence with the place in the list, where it cannot be read.
    """
    if len(text) > LARGEST:
        raise ParameterError(f'{source} is longer than {LARGEST} characters')
    try:
        content = yaml.load(text, _Loader)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, 'problem_mark', None)
        place = f', line {mark.line + 1}' if mark is not None else ''
        problem = getattr(error, 'problem', None) or ' '.join(str(error).split())
        raise ParameterError(f'{source}{place}: not YAML: {problem}') from None
    return _injections(content, source)


def read_timetable_file(path: str) -> list[Injection]:
    """Return the injections of a timetable in a file; ParameterError also where there is none."""
    try:
        with Path(path).open(encoding='utf-8') as stream:
            text = stream.read(LARGEST + 1)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is not text in UTF-8'
        raise ParameterError(f'{path}: cannot be read: {reason}') from None
    return read_timetable(text, path)


def _injections(content: Any, source: str) -> list[Injection]:
    if content is None:
        return []
    entries = content if isinstance(content, Sequence) and not isinstance(content, str) else [
        content]
    found = []
    for number, entry in enumerate(entries, 1):
        if not isinstance(entry, dict):
            raise ParameterError(
                f'{source}, fault {number}: a fault has fields (fault: stem_friction, at: 5.0), '
                f'got {shown(entry)}')
        try:
            found.append(injection(entry))
        except ParameterError as error:
            raise ParameterError(f'{source}, fault {number}: {error}') from None
    return found


class _Loader(yaml.SafeLoader):
    """Reads numbers with an exponent but without a point, as ROS 2 does; knows no aliases."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; an alias could make a small text a large one."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError('aliases (*name) are not read')
        return super().compose_node(parent, index)


_Loader.yaml_implicit_resolvers = {
    first: list(resolvers) for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()}
_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$'), list('-+0123456789.'))
