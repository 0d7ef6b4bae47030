# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The layout of a ROS 2 parameter file: which node each section is for, and what it holds.

A file is read as rcl reads it, see `scalars`. Line numbers are kept, so that whoever complains can
say where.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from ..model.parameters import ParameterError
from .scalars import scalar

PARAMETERS_KEY = 'ros__parameters'
ANY_NODE = ('*', '**')
EVERY_NODE = '/**'

LARGEST_FILE = 1_000_000
"""Bytes of a parameter file; the parameters of a positioner with an effect have 4 kB."""

MOST_SECTIONS = 1000
"""Sections of a parameter file, one for each node."""

_LONGEST_NAME = 1000

_QUOTES = ("'", '"')
_TEXT_TAG = 'tag:yaml.org,2002:str'


class Entry(NamedTuple):
    """One parameter of a file: dotted name, value, and the line (from 1) that it stands on."""

    name: str
    value: Any
    line: int


class Section(NamedTuple):
    """What a file holds for the nodes that a name means, such as `/**` or `/a/positioner`."""

    written: str
    """The name as the file has it, nested ones joined by slashes."""
    entries: tuple[Entry, ...]

    @property
    def node(self) -> str:
        """The name from the root on, however it is written."""
        return '/' + '/'.join(part for part in self.written.split('/') if part)


class _Loader(yaml.BaseLoader):
    """Composes nodes, and leaves open what a scalar is unless the file has a tag for it."""

    def resolve(self, kind: type[yaml.Node], value: Any, implicit: Any) -> str:
        """Return the tag of a node that the file gives none."""
        return '' if kind is yaml.ScalarNode else super().resolve(kind, value, implicit)

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; refuse what ROS 2 does not read."""
        if self.check_event(yaml.AliasEvent):
            raise _LayoutError(
                self.peek_event().start_mark.line + 1, 'ROS 2 reads no aliases (*name)')
        return super().compose_node(parent, index)


def read_sections(path: str | Path) -> list[Section]:
    """
    Return the sections of a parameter file in an order in which later ones override earlier ones.

    ParameterError names the file and the line.
    """
    try:
        text = _text(path)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is not text in UTF-8'
        raise ParameterError(f'{path}: cannot be read: {reason}') from None
    try:
        return _in_order(list(_sections(_Loader(text).get_single_node(), '')))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f', line {mark.line + 1}' if mark is not None else ''
        raise ParameterError(f'{path}{place}: not YAML: {error.problem}') from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ParameterError(f'{path}: not YAML: {" ".join(str(error).split())}') from None
    except _LayoutError as error:
        raise ParameterError(f'{path}{error}') from None


def _text(path: str | Path) -> str:
    with open(path, 'rb') as file:
        data = file.read(LARGEST_FILE + 1)
    if len(data) > LARGEST_FILE:
        raise ParameterError(
            f'{path}: has more than {LARGEST_FILE} bytes, which no parameter file has')
    return data.decode()


def _in_order(sections: list[Section]) -> list[Section]:
    """
    Return the sections in the order in which rcl lets later ones override earlier ones.

    It is the order of the file; but sections whose names are written alike are one to rcl, which
    stands where the first of them does.
    """
    if len(sections) > MOST_SECTIONS:
        raise _LayoutError(None, f'has {len(sections)} sections, more than {MOST_SECTIONS}')
    names = [section.written for section in sections]
    return sorted(sections, key=lambda section: names.index(section.written))


class _LayoutError(Exception):
    """YAML, but not a ROS 2 parameter file; the text goes behind the file's name."""

    def __init__(self, line: int | None, problem: str) -> None:
        super().__init__(f'{"" if line is None else f", line {line}"}: {problem}')


def _line(node: yaml.Node | None) -> int | None:
    return None if node is None else node.start_mark.line + 1


def _sections(node: yaml.Node | None, name: str) -> Iterator[Section]:
    if not isinstance(node, yaml.MappingNode):
        raise _LayoutError(
            _line(node), f'a ROS 2 parameter file has `/**:`, `{PARAMETERS_KEY}:` and the '
            'parameters below each other')
    for key_node, value in node.value:
        key = _name(key_node)
        if key == PARAMETERS_KEY:
            if not name:
                raise _LayoutError(
                    _line(key_node), f'`{PARAMETERS_KEY}:` belongs below a node name, or `/**:` '
                    'for any node')
            yield Section(name, tuple(_checked(_entries(value, ''))))
        else:
            yield from _sections(value, f'{name}/{key}' if name else key)


def _name(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        raise _LayoutError(_line(node), 'a name must be a word')
    if len(node.value) > _LONGEST_NAME:
        raise _LayoutError(_line(node), f'a name is longer than {_LONGEST_NAME} characters')
    return str(node.value)


def _value(node: yaml.Node, name: str) -> Any:
    """Return the value of a parameter, None where there is none."""
    if isinstance(node, yaml.SequenceNode):
        return [_value(item, name) for item in node.value]
    if not isinstance(node, yaml.ScalarNode):
        raise _LayoutError(_line(node), f'{name} is a list, which holds values only')
    if node.style in _QUOTES or node.tag == _TEXT_TAG:
        return node.value
    return scalar(node.value) if node.value else None


def _entries(node: yaml.Node, name: str) -> Iterator[Entry]:
    if not isinstance(node, yaml.MappingNode):
        value = _value(node, name)
        if not name:
            raise _LayoutError(_line(node), f'`{PARAMETERS_KEY}:` holds no parameters')
        if value is None:
            raise _LayoutError(_line(node), f'{name} has no value')
        if isinstance(value, list) and len({type(item) for item in value}) > 1:
            raise _LayoutError(
                _line(node), f'{name} mixes types, which ROS 2 does not read: write 1.0 for 1 in '
                'a list of numbers')
        yield Entry(name, value, node.start_mark.line + 1)
        return
    for key_node, value_node in node.value:
        key = _name(key_node)
        yield from _entries(value_node, f'{name}.{key}' if name else key)


def _checked(entries: Iterator[Entry]) -> Iterator[Entry]:
    seen: dict[str, int] = {}
    for entry in entries:
        if entry.name in seen:
            raise _LayoutError(
                entry.line, f'{entry.name} is given again, first in line {seen[entry.name]}')
        seen[entry.name] = entry.line
        yield entry


def files_on(arguments: Sequence[str]) -> list[str]:
    """Return the parameter files that the arguments of a ROS 2 program name."""
    return [path for flag, path in pairwise(arguments) if flag == '--params-file']


def is_for(section: str, node: str) -> bool:
    """
    Tell whether a section's name, wildcards included, means the node of this full name.

    >>> is_for('/**', '/a/positioner'), is_for('/*/positioner', '/positioner')
    (True, False)
    """
    return _match(section.strip('/').split('/'), node.strip('/').split('/'))


def _match(pattern: list[str], name: list[str]) -> bool:
    # which beginnings of the name the pattern so far matches: the time grows with both, not faster
    reached = [True, *(False for _ in name)]
    for part in pattern:
        if part == '**':
            reached = [any(reached[:k + 1]) for k in range(len(reached))]
        else:
            reached = [False, *(before and part in ('*', one)
                                for before, one in zip(reached, name))]
    return reached[-1]
