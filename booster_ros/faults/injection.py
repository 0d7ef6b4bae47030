# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One fault to come: which, how strong, and from when to when."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
import numbers
import operator
from typing import Any

from ..model.outputs import Outputs
from ..model.parameters import DESCRIPTIONS, ParameterError, checked_value, shown, unknown_name
from .kinds import STRENGTHS, Fault, fault_named

_RELATIONS = {'>': operator.gt, '<': operator.lt, '>=': operator.ge, '<=': operator.le}
_FIELDS = (
    'fault', 'strength', 'size', 'parameters', 'at', 'at_tick', 'when', 'ramp', 'until',
    'until_tick', 'until_when', 'duration', 'ramp_down')


@dataclass(frozen=True)
class Condition:
    """A comparison of one output (names as in `~/state`) with a number in SI units."""

    output: str
    relation: str
    value: float

    def holds(self, outputs: Outputs) -> bool:
        """Tell whether it holds now."""
        return bool(_RELATIONS[self.relation](getattr(outputs, self.output), self.value))


@dataclass(frozen=True)
class Moment:
    """When something happens: a time (s), a tick, or once a condition holds. One is given."""

    time: float | None = None
    tick: int | None = None
    condition: Condition | None = None

    def has_come(self, time: float, tick: int, outputs: Outputs | None) -> bool:
        """Tell whether it has come; `outputs` are needed for a condition only."""
        if self.condition is not None:
            return outputs is not None and self.condition.holds(outputs)
        if self.tick is not None:
            return tick >= self.tick
        # half a nanosecond, as a time that is written is rarely a float
        return self.time is not None and time >= self.time - 5e-10


AT_ONCE = Moment(time=-math.inf)
NEVER = Moment()


@dataclass(frozen=True)
class Injection:
    """
    A fault to come. Strength counts in sizes that a record shows well, see `kinds`.

    `parameters` are values at full strength instead of those that the strength makes, `size` is
    in the unit of a sensor's reading. It is on from `begin` until `end` or for `duration` (s);
    its strength grows over `ramp` (s) and falls over `ramp_down` (s).
    """

    fault: Fault
    strength: float
    begin: Moment = AT_ONCE
    end: Moment = NEVER
    duration: float = math.inf
    ramp: float = 0.0
    ramp_down: float = 0.0
    size: float | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of the fault."""
        return self.fault.name


def injection(given: Mapping[str, Any]) -> Injection:
    """
    Return an injection from its fields; ParameterError, one sentence, where one is none.

    >>> injection({'fault': 'f4', 'strength': 'big', 'ramp': 5}).strength
    4.0
    """
    for name in given:
        if name not in _FIELDS:
            raise ParameterError(unknown_name(str(name), _FIELDS).replace('parameter', 'field', 1))
    if not isinstance(given.get('fault'), str):
        raise ParameterError('a fault must have a name: fault: stem_friction, for example')
    fault = fault_named(given['fault'])
    made = Injection(
        fault, _strength(given.get('strength', fault.strength)),
        _moment(given, 'at', 'at_tick', 'when', AT_ONCE),
        _moment(given, 'until', 'until_tick', 'until_when', NEVER),
        _number(given, 'duration', math.inf), _number(given, 'ramp', 0.0),
        _number(given, 'ramp_down', 0.0), _size(given, fault), _parameters(given, fault))
    if made.end is not NEVER and made.duration < math.inf:
        raise ParameterError(f'{fault.name}: either duration or until, not both')
    return made


def condition(text: Any) -> Condition:
    """Return the condition that a text states, such as `valve_position > 0.008`."""
    parts = text.split() if isinstance(text, str) else []
    if len(parts) != 3 or parts[1] not in _RELATIONS:
        raise ParameterError(
            f'a condition is an output, one of {" ".join(_RELATIONS)}, and a number '
            f'(valve_position > 0.008), got {shown(text)}')
    if parts[0] not in Outputs._fields:
        raise ParameterError(
            unknown_name(parts[0], Outputs._fields).replace('parameter', 'output', 1))
    try:
        value = float(parts[2])
    except ValueError:
        raise ParameterError(
            f'a condition compares with a number in SI units, got {shown(parts[2])}') from None
    return Condition(parts[0], parts[1], value)


def _strength(value: Any) -> float:
    if isinstance(value, str) and value in STRENGTHS:
        return STRENGTHS[value]
    number = _real(value)
    if number is None or not math.isfinite(number):
        raise ParameterError(
            f'strength must be a number, or one of {", ".join(STRENGTHS)}, got {shown(value)}')
    return number


def _moment(
    given: Mapping[str, Any], time: str, tick: str, when: str, default: Moment
) -> Moment:
    named = [name for name in (time, tick, when) if name in given]
    if len(named) > 1:
        raise ParameterError(f'one of {", ".join(named)}, not all of them')
    if not named:
        return default
    value = given[named[0]]
    if named[0] == when:
        return Moment(condition=condition(value))
    if named[0] == tick:
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ParameterError(f'{tick} must be a whole number from 0 on, got {shown(value)}')
        return Moment(tick=value)
    return Moment(time=_number(given, time, 0.0))


def _number(given: Mapping[str, Any], name: str, default: float) -> float:
    value = given.get(name, default)
    number = _real(value)
    if number is None or math.isnan(number) or number < 0.0:
        raise ParameterError(f'{name} must be a number of seconds from 0 on, got {shown(value)}')
    return number


def _size(given: Mapping[str, Any], fault: Fault) -> float | None:
    value = given.get('size')
    if value is None:
        return None
    number = _real(value)
    if not fault.sensor:
        raise ParameterError(f'size is for faults of a sensor; {fault.name} has parameters')
    if number is None or not math.isfinite(number) or number < 0.0:
        raise ParameterError(f'size must be a number from 0 on, got {shown(value)}')
    return number


def _parameters(given: Mapping[str, Any], fault: Fault) -> dict[str, Any]:
    values = given.get('parameters', {})
    if not isinstance(values, Mapping):
        raise ParameterError(
            f'parameters must be names and values, got {shown(values)}')
    if values and fault.sensor:
        raise ParameterError(f'{fault.name} has a size, and no parameters')
    for name, value in values.items():
        description = DESCRIPTIONS.get(name)
        if description is None:
            raise ParameterError(unknown_name(str(name), DESCRIPTIONS))
        if not isinstance(description.default, float):
            raise ParameterError(f'{name} cannot be the parameter of a fault: it is no number')
        checked_value(description, value)
    return {name: float(value) for name, value in values.items()}


def _real(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return None
    return float(value)
