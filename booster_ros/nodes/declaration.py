# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Declare the parameters of the table in a node, and watch over their changes."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
import contextlib
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..model.catalogue import is_optional
from ..model.parameters import Description, ParameterError
from ..parameters.file import section_values
from ..parameters.scalars import scalar
from ..parameters.schema import (
    ALL_DESCRIPTIONS,
    READ_ONLY,
    Parameters,
    belongs_to_ros,
    check,
    checked,
)
from ..parameters.sections import files_on, is_for, read_sections

Checked = TypeVar('Checked')


@contextlib.contextmanager
def destroyed_if_refused(node: Node) -> Iterator[None]:
    """
    Destroy a node whose making fails within, as where a parameter is refused.

    Who made it has nothing to destroy it by, and it would be seen by others until Python clears up.
    """
    try:
        yield
    except BaseException:
        Node.destroy_node(node)
        raise


def overrides_of(values: Mapping[str, Any]) -> list[Parameter]:
    """Return values by dotted name as what a node is given at its start."""
    return [Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            for name, value in values.items()]


def declare(node: Node) -> Parameters:
    """Declare the positioner's parameters, see `declare_table`."""
    return declare_table(node, ALL_DESCRIPTIONS, READ_ONLY, checked, check)


def declare_table(
    node: Node,
    descriptions: Mapping[str, Description],
    read_only: Collection[str],
    checked: Callable[[str, Any], Any],
    check: Callable[[Mapping[str, Any]], Checked],
) -> Checked:
    """
    Declare every parameter with its descriptor, and return what the node was given, checked.

    `checked` returns one value in the kind that is declared, `check` all of them together. The node
    must have been made with `automatically_declare_parameters_from_overrides`, which shows all that
    it was given, misspelt names as well. ParameterError is raised before any is declared.
    """
    given = {
        name: node.get_parameter(name).value
        for name in node.list_parameters([], 0).names
        if not belongs_to_ros(name)
    }
    parameters = check(given)
    for name in given:
        node.undeclare_parameter(name)
    for name, description in descriptions.items():
        value = checked(name, given.get(name, description.default))
        node.declare_parameter(
            name, list(value) if isinstance(value, tuple) else value,
            descriptor(description, name in read_only), ignore_override=True)
    return parameters


def descriptor(description: Description, read_only: bool = False) -> ParameterDescriptor:
    """Return what `ros2 param describe` shows of a parameter."""
    limits = f'{description.low:g} to {description.high:g} {description.unit}'
    if description.choices:
        limits = f'one of {", ".join(description.choices)}'
    elif isinstance(description.default, str):
        limits = 'text'
    elif isinstance(description.default, bool):
        limits = 'true or false'
    made = ParameterDescriptor(
        description=f'{description.meaning} [{description.unit}]',
        additional_constraints=f'{limits}; default from: {description.source}',
        read_only=read_only)
    if isinstance(description.default, float):
        made.floating_point_range = [
            FloatingPointRange(from_value=description.low, to_value=description.high)]
    return made


class ParameterWatch:
    """
    Guards the changes of a node's declared parameters at run time.

    A change that does not fit the other parameters is refused with the reason, and nothing of it
    is kept; `examine` may raise ParameterError as well. A value that is in force already is no
    change. After one that fits, `changed` is called with all parameters, checked together.
    A float may be given as any number: as `400000`, or as `9e9`, which arrives as a text.
    """

    def __init__(
        self, node: Node, changed: Callable[[Parameters], None],
        examine: Callable[[Parameters], object],
    ) -> None:
        self._node = node
        self._changed = changed
        self._examine = examine
        self.changes = 0
        """Changes so far."""
        self._values = {
            name: _plain(node.get_parameter(name).value) for name in ALL_DESCRIPTIONS}
        self.last_change = ''
        """Names and values of the last change."""
        node.add_pre_set_parameters_callback(
            lambda proposed: [as_declared(parameter) for parameter in proposed])
        node.add_on_set_parameters_callback(self._validate)
        node.add_post_set_parameters_callback(self._apply)

    def _check(self, proposed: list[Parameter]) -> Parameters:
        values = {name: self._node.get_parameter(name).value for name in ALL_DESCRIPTIONS}
        values |= {p.name: p.value for p in proposed if p.name in ALL_DESCRIPTIONS}
        return check(values)

    def _validate(self, proposed: list[Parameter]) -> SetParametersResult:
        try:
            self._examine(self._check(proposed))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply(self, applied: list[Parameter]) -> None:
        ours = [parameter for parameter in applied if parameter.name in ALL_DESCRIPTIONS]
        ours = [p for p in ours if _plain(p.value) != self._values[p.name]]
        if ours:
            self._values |= {p.name: _plain(p.value) for p in ours}
            self.changes += 1
            self.last_change = ', '.join(f'{p.name} = {_plain(p.value)}' for p in ours)
            self._changed(self._check(ours))


def as_declared(parameter: Parameter) -> Parameter:
    """
    Return the parameter with its numbers as floats where floats are declared.

    A value that is no number (nor, where a single float is declared, the text of one) is left to
    the type check.
    """
    description = ALL_DESCRIPTIONS.get(parameter.name)
    if description is None:
        return parameter
    value = parameter.value
    if isinstance(description.default, float):
        number = scalar(value) if isinstance(value, str) else value
        if _is_number(number):
            return Parameter(parameter.name, Parameter.Type.DOUBLE, float(number))
    elif parameter.type_ == Parameter.Type.INTEGER_ARRAY and isinstance(
            description.default, tuple):
        return Parameter(
            parameter.name, Parameter.Type.DOUBLE_ARRAY, [float(item) for item in value])
    return parameter


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _plain(value: Any) -> Any:
    """Return a value, an array of rclpy's as a list."""
    return list(value) if hasattr(value, '__len__') and not isinstance(value, str) else value


def effective_values(parameters: dict[str, Any]) -> str:
    """
    Return the values in force for people to read, a line for each component of the model.

    Parameters of effects and of the loop appear only where they differ from their defaults.
    """
    lines: dict[str, list[str]] = {}
    for name, description in ALL_DESCRIPTIONS.items():
        value = parameters[name]
        default = description.default
        plain = _plain(value)
        is_default = plain == _plain(default)
        if is_default and is_optional(name):
            continue
        component, _, field = name.rpartition('.')
        mark = '' if is_default else '*'
        shown = 'empty' if plain == '' else plain
        lines.setdefault(component or 'node', []).append(f'{mark}{field} {shown}')
    return '\n'.join(f'  {component}: {", ".join(texts)}' for component, texts in lines.items())


def files_without_section(arguments: Sequence[str], node: str) -> list[tuple[str, str]]:
    """
    Return the parameter files on a command line that hold nothing for a node, with their sections.

    ROS 2 says nothing about a file whose node names match no node.
    """
    found = []
    for path in files_on(arguments):
        names = [section.node for section in read_sections(path)]
        if not any(is_for(name, node) for name in names):
            found.append((path, ', '.join(names)))
    return found


def check_files(
    arguments: Sequence[str], node: str, checked: Callable[[str, Any], Any]
) -> None:
    """
    Check what parameter files on a command line hold for the node of this full name.

    The node is told values only; here ParameterError can say in which file and line each stands.
    """
    for path in files_on(arguments):
        for section in read_sections(path):
            if is_for(section.node, node):
                section_values(path, section, checked)
