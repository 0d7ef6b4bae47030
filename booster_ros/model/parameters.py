# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From dotted names and values to checked parameters, and back."""

from array import array
from collections.abc import Iterable, Mapping
import dataclasses
import difflib
from itertools import pairwise
import math
import numbers
from typing import Any, NamedTuple, get_type_hints

from . import discrepancy, position_controller
from .quantity import Quantity
from .system import PositionerParameters

Value = float | str | bool | tuple[float, ...]

_CHOICES = {
    'booster.orifice_law': ('iso_6358', 'isentropic'),
    'booster.kind': ('three_diaphragms', 'none'),
    'actuator.kind': ('stem', 'vessel'),
    'discrepancy.location': discrepancy.LOCATIONS,
    'discrepancy.variable': discrepancy.VARIABLES,
    'position_controller.output': position_controller.OUTPUTS,
    'position_controller.action': position_controller.ACTIONS,
    'position_controller.characteristic': position_controller.CHARACTERISTICS,
}

LONGEST_QUOTE = 60
"""Most characters of a value that a sentence quotes."""


class ParameterError(ValueError):
    """A parameter that cannot be used; the message is one sentence that names it."""


@dataclasses.dataclass(frozen=True)
class Description:
    """A parameter as a user sees it; `choices` are the words allowed where the value is a word."""

    name: str
    default: Value
    unit: str
    meaning: str
    low: float
    high: float
    source: str
    choices: tuple[str, ...] = ()


def _describe() -> dict[str, Description]:
    found = {}
    for component, default in PositionerParameters()._asdict().items():
        hints = get_type_hints(type(default), include_extras=True)
        for field, hint in hints.items():
            name = f'{component}.{field}'
            quantity: Quantity = hint.__metadata__[0]
            choices = _CHOICES.get(name, ())
            value = getattr(default, field)
            found[name] = Description(
                name, choices[value] if choices else value, quantity.unit, quantity.meaning,
                quantity.low, quantity.high, quantity.source, choices)
    return found


DESCRIPTIONS: dict[str, Description] = _describe()
"""Every physical parameter by its dotted name, those of effects included."""


def unknown_name(name: str, known: Iterable[str]) -> str:
    """Return the sentence about a parameter name that does not exist, with the nearest one."""
    if len(name) > LONGEST_QUOTE:  # to look for one that is near takes long
        return f'there is no parameter {name[:LONGEST_QUOTE]}...'
    near = difflib.get_close_matches(name, list(known), 1, 0.6)
    hint = f'; did you mean {near[0]}?' if near else ''
    return f'there is no parameter {name}{hint}'


def from_values(values: Mapping[str, Any]) -> PositionerParameters:
    """
    Return checked parameters from dotted names and values in SI; what is missing has its default.

    Raise ParameterError for an unknown name, a value of the wrong kind or out of its range, and
    for a set that contradicts itself. Real numbers of any kind are taken where a float is meant,
    those of numpy too.
    """
    for name in values:
        if name not in DESCRIPTIONS:
            raise ParameterError(unknown_name(name, DESCRIPTIONS))
    components: dict[str, Any] = {}
    for component, default in PositionerParameters()._asdict().items():
        given = {
            field: checked_value(DESCRIPTIONS[f'{component}.{field}'],
                                 values[f'{component}.{field}'])
            for field in default._fields if f'{component}.{field}' in values
        }
        components[component] = default._replace(**given)
    parameters = PositionerParameters(**components)
    check_consistent(parameters)
    return parameters


def to_values(parameters: PositionerParameters) -> dict[str, Value]:
    """Return dotted names and values, the inverse of `from_values`."""
    values: dict[str, Value] = {}
    for component, content in parameters._asdict().items():
        for field, value in content._asdict().items():
            name = f'{component}.{field}'
            choices = _CHOICES.get(name)
            values[name] = choices[value] if choices else value
    return values


def shown(value: Any) -> str:
    """Return a value as a sentence quotes it: only the beginning of a long one."""
    try:
        text = repr(list(value) if isinstance(value, array) else value)
    except ValueError:  # Python writes out no whole number of more than 4300 digits
        return 'a whole number of thousands of digits'
    return text if len(text) <= LONGEST_QUOTE else f'{text[:LONGEST_QUOTE]}...'


def checked_value(description: Description, value: Any) -> Any:
    """Return a value as the model holds it; ParameterError where kind or range is wrong."""
    name = description.name
    if description.choices:
        if value not in description.choices:
            raise ParameterError(
                f'{name} must be one of {", ".join(description.choices)}, got {shown(value)}')
        return description.choices.index(value)
    if isinstance(description.default, bool):
        if not isinstance(value, bool):
            raise ParameterError(f'{name} must be true or false, got {shown(value)}')
        return value
    if isinstance(description.default, tuple):
        size = len(description.default)
        if isinstance(value, (str, bytes)) or not hasattr(value, '__len__') or len(value) != size:
            raise ParameterError(f'{name} must be a list of {size} numbers, got {shown(value)}')
        return tuple(_checked_number(description, element) for element in value)
    return _checked_number(description, value)


def _checked_number(description: Description, value: Any) -> float:
    name, unit = description.name, description.unit
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise ParameterError(
            f'{name} must be a number in {unit}, got {shown(value)} (write for example '
            f'{_example(description.default)})')
    try:
        number = float(value)
    except OverflowError:
        raise ParameterError(
            f'{name} must be a number that a float can hold, got {shown(value)}') from None
    if not math.isfinite(number):
        raise ParameterError(f'{name} must be finite, got {shown(value)}')
    if not description.low <= number <= description.high:
        raise ParameterError(
            f'{name} must be between {description.low:g} and {description.high:g} {unit}, '
            f'got {number:g}')
    return number


def _example(default: Value) -> str:
    return repr(default[0] if isinstance(default, tuple) else default)


class _Rule(NamedTuple):
    holds: bool
    sentence: str


def _controller_rules(c: position_controller.PositionController) -> tuple[_Rule, ...]:
    table = c.characteristic_table
    return (
        _Rule(c.current_limits[0] < c.current_limits[1],
              f'position_controller.current_limits must rise, got {shown(c.current_limits)} A'),
        _Rule(c.signal_range[0] != c.signal_range[1],
              'position_controller.signal_range must be two currents that differ, got '
              f'{shown(c.signal_range)} A'),
        _Rule(all(one <= another for one, another in pairwise(table)),
              'position_controller.characteristic_table must not fall from any value to the next, '
              f'got {shown(table)}'),
    )


def check_consistent(p: PositionerParameters) -> None:
    """Raise ParameterError where parameters, each fine by itself, contradict each other."""
    b, s, a, d = p.booster, p.supply, p.actuator, p.discrepancy
    ratio = b.critical_pressure_ratio + b.critical_pressure_ratio_shift
    rules = (
        _Rule(b.s1 > b.s2, f'booster.s1 ({b.s1:g} m^2) must be greater than booster.s2 '
              f'({b.s2:g} m^2)'),
        _Rule(b.s2 > b.s3, f'booster.s2 ({b.s2:g} m^2) must be greater than booster.s3 '
              f'({b.s3:g} m^2)'),
        _Rule(s.ripple <= s.pressure,
              f'supply.ripple ({s.ripple:g} Pa) must not be greater than supply.pressure '
              f'({s.pressure:g} Pa)'),
        _Rule(a.bench_set[1] > a.bench_set[0],
              f'actuator.bench_set must rise, got [{a.bench_set[0]:g}, {a.bench_set[1]:g}] Pa'),
        _Rule(a.lower_travel_lost + a.upper_travel_lost < 1.0,
              'actuator.lower_travel_lost plus actuator.upper_travel_lost must be less than 1, '
              f'got {a.lower_travel_lost + a.upper_travel_lost:g}'),
        _Rule(0.0 <= ratio < 0.99,
              'booster.critical_pressure_ratio plus its shift must be between 0 and 0.99, '
              f'got {ratio:g}'),
        _Rule(a.dead_volume + a.added_volume > 0.0,
              'actuator.dead_volume plus actuator.added_volume must be greater than 0 m^3, got '
              f'{a.dead_volume + a.added_volume:g}'),
        _Rule(all(one < another for one, another in zip(d.knots, d.knots[1:])),
              'discrepancy.knots must rise from each value to the next, got '
              f'{shown(d.knots)}'),
        _Rule(discrepancy.can_depend(d.location, d.variable),
              f'discrepancy.variable: {discrepancy.VARIABLES[d.variable]} is nothing that a term '
              f'in {discrepancy.LOCATIONS[d.location]} can follow'),
        *_controller_rules(p.position_controller),
    )
    for rule in rules:
        if not rule.holds:
            raise ParameterError(rule.sentence)


def is_consistent(p: PositionerParameters) -> bool:
    """Tell whether no parameters, each fine by itself, contradict each other."""
    try:
        check_consistent(p)
    except ParameterError:
        return False
    return True
