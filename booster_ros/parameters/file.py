# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Parameter files: the standard ROS 2 format, read and written without ROS.

The same file feeds the node (`--ros-args --params-file`), `simulate` and `close_loop`.
"""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from ..model.catalogue import is_optional
from ..model.parameters import DESCRIPTIONS, Description, ParameterError, to_values
from ..model.system import PositionerParameters
from ..writing.replacement import write_file
from .schema import NODE_DESCRIPTIONS, belongs_to_ros, check, checked
from .scalars import LEAST
from .sections import ANY_NODE, EVERY_NODE, PARAMETERS_KEY, Section, is_for, read_sections


class ParameterFile(NamedTuple):
    """What a file holds for one node: the model's parameters and the node's own, checked."""

    path: str
    physical: dict[str, Any]
    node: dict[str, Any]


def read_parameter_file(path: str | Path, node: str = 'positioner') -> ParameterFile:
    """
    Return what a parameter file holds for a node, given by its name or its full name.

    The last section that is for the node counts, as in ROS 2: `/**` below a node's own section
    overrides it. ParameterError (one sentence naming file, line and parameter) for a file that
    cannot be read, misspelt or unknown names, wrong kinds, ranges and contradictions, and when
    no section is for the node, or the sections are for more than one node of that name.
    """
    values: dict[str, Any] = {}
    for section in _sections_for(path, read_sections(path), node):
        values |= section_values(path, section, checked)
    try:
        check(values)
    except ParameterError as error:
        raise ParameterError(f'{path}: {error}') from None
    return ParameterFile(
        str(path),
        {name: value for name, value in values.items() if name in DESCRIPTIONS},
        {name: value for name, value in values.items() if name not in DESCRIPTIONS})


def section_values(
    path: str | Path, section: Section, checked: Callable[[str, Any], Any]
) -> dict[str, Any]:
    """Return what a section gives a node; ParameterError names file, line and parameter."""
    values: dict[str, Any] = {}
    for name, value, line in section.entries:
        try:
            if not belongs_to_ros(name):
                values[name] = checked(name, value)
        except ParameterError as error:
            raise ParameterError(f'{path}, line {line}: {error}') from None
    return values


def _sections_for(path: str | Path, sections: list[Section], node: str) -> list[Section]:
    """Return the sections that a node reads, in the order in which they are given."""
    if '/' in node:
        found = [section for section in sections if is_for(section.node, node)]
    else:
        found = [section for section in sections if section.node.rsplit('/', 1)[-1] in
                 (node, *ANY_NODE)]
        _check_one_node(path, [section.node for section in found], node)
    if not found:
        there = ', '.join(section.node for section in sections) or 'none'
        raise ParameterError(f'{path}: has no section for {node} (sections: {there})')
    return found


def _check_one_node(path: str | Path, names: list[str], node: str) -> None:
    """Raise ParameterError unless one node of this name, in some namespace, reads all sections."""
    instances = [_instance(name, node) for name in names]
    if names and not any(all(is_for(name, one) for name in names) for one in instances):
        told = ', '.join(sorted({name for name in names if name != EVERY_NODE}))
        raise ParameterError(f'{path}: has sections for {told}: more than one {node}')


def _instance(section: str, node: str) -> str:
    """Return a full name, ending in `node`, that a section's name with its wildcards means."""
    *namespaces, _ = section.split('/')
    return '/'.join([*(part for part in namespaces if part != '**'), node])


def write_parameter_file(
    path: str | Path,
    parameters: PositionerParameters,
    heading: str = '',
    comments: Mapping[str, str] | None = None,
    node: Mapping[str, Any] | None = None,
) -> None:
    """
    Write a parameter file for any positioner node, complete or not at all.

    It holds every parameter of the declared model, those parameters of effects and of the position
    controller that have a comment or a value other than by default, and those of `node`, the node's
    own. `heading` becomes the comment above, `comments` (by dotted name) stand behind the units.
    """
    text = parameter_text(parameters, heading, comments or {}, node or {})
    write_file(Path(path), text.encode())


def parameter_text(
    parameters: PositionerParameters, heading: str, comments: Mapping[str, str],
    node: Mapping[str, Any],
) -> str:
    """Return the text of a parameter file, see `write_parameter_file`."""
    lines = [f'# {line}'.rstrip() for line in heading.splitlines()]
    lines += [f'{EVERY_NODE}:', f'  {PARAMETERS_KEY}:']
    component = ''
    for name, value, description in _entries(parameters, comments, node):
        before, _, field = name.rpartition('.')
        if before != component:
            component = before
            lines.append(f'    {component}:')
        comment = '; '.join(text for text in (description.unit, comments.get(name, '')) if text)
        lines.append(f'{"      " if before else "    "}{field}: '
                     f'{_scalar(value, description)}  # {comment}')
    return '\n'.join(lines) + '\n'


def _entries(
    parameters: PositionerParameters, comments: Mapping[str, str], node: Mapping[str, Any],
) -> Iterator[tuple[str, Any, Description]]:
    """Yield name, value and description of what a file holds, parameters of no component first."""
    for name in sorted(node, key=lambda name: name.count('.')):
        yield name, node[name], NODE_DESCRIPTIONS[name]
    for name, value in to_values(parameters).items():
        description = DESCRIPTIONS[name]
        if not is_optional(name) or value != description.default or name in comments:
            yield name, value, description


def _number(value: Any) -> float:
    """Return a number, numpy's or Python's, as one that ROS 2 reads: 0 for sizes below `LEAST`."""
    return float(value) if abs(value) >= LEAST else 0.0


def _scalar(value: Any, description: Description) -> str:
    """Return a value as YAML; floats always with a point, which YAML 1.1 readers want."""
    plain: Any = value
    if isinstance(value, tuple):
        plain = [_number(element) for element in value]
    elif isinstance(description.default, float):
        plain = _number(value)
    return yaml.safe_dump([plain], default_flow_style=True, width=10_000).strip()[1:-1]
