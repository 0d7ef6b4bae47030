# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What faults make of the physical parameters."""

from collections.abc import Iterable

from ..model.catalogue import Knob
from ..model.parameters import DESCRIPTIONS, ParameterError, check_consistent
from ..model.system import PositionerParameters
from .injection import Injection
from .kinds import SUPPLY_LOSS, SUPPLY_SHARE

_SUPPLY = 'supply.pressure'


def with_faults(
    base: PositionerParameters, acting: Iterable[tuple[Injection, float]]
) -> PositionerParameters:
    """
    Return parameters with faults at shares (0 to 1) of their full strength.

    Faults that turn the same size add up. ParameterError where a value leaves its range, or values
    contradict each other.
    """
    values: dict[str, float] = {}

    def value(name: str) -> float:
        return values[name] if name in values else _get(base, name)

    for injection, share in acting:
        for knob in injection.fault.knobs:
            if not injection.parameters:
                values[knob.parameter] = _turned(
                    knob, value(knob.parameter), injection.strength * share)
        if injection.name == SUPPLY_LOSS and not injection.parameters:
            left = 1.0 - SUPPLY_SHARE * injection.strength * share
            values[_SUPPLY] = value(_SUPPLY) * max(left, 0.0)
        for name, target in injection.parameters.items():
            before = value(name)
            values[name] = before + share * (target - before)
    if not values:
        return base
    parameters = _replaced(base, values)
    check_consistent(parameters)
    return parameters


def _turned(knob: Knob, value: float, strength: float) -> float:
    """Return a value that is `strength` times the typical size further from neutral."""
    typical = knob.to_fit(knob.typical) - knob.to_fit(knob.neutral)
    return knob.from_fit(knob.to_fit(value) + strength * typical)


def _get(parameters: PositionerParameters, name: str) -> float:
    component, _, field = name.partition('.')
    return float(getattr(getattr(parameters, component), field))


def _replaced(base: PositionerParameters, values: dict[str, float]) -> PositionerParameters:
    components: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        description = DESCRIPTIONS[name]
        if not description.low <= value <= description.high:
            raise ParameterError(
                f'the faults together make {name} {value:g} {description.unit}, which must be '
                f'between {description.low:g} and {description.high:g}')
        component, _, field = name.partition('.')
        components.setdefault(component, {})[field] = value
    return base._replace(**{
        component: getattr(base, component)._replace(**fields)
        for component, fields in components.items()})
