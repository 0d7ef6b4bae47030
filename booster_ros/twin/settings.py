# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the node `twin`: one table, checked together, without ROS."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..model.catalogue import EFFECTS
from ..model.parameters import Description, ParameterError, unknown_name
from ..parameters.schema import checked_as
from .alarm import Settings

_DEFAULTS = Settings()

DESCRIPTIONS: dict[str, Description] = {
    one.name: one for one in (
        Description(
            'model', '', '-', 'parameter file of the model to run beside the valve; empty: the '
            'positioner of the paper', -1.0, 1.0, 'none'),
        Description(
            'store', '', '-', 'SQLite file in which trends and alarms are kept; empty: none',
            -1.0, 1.0, 'none'),
        Description(
            'rate', 2.0, 'Hz', 'how often samples are used and results published', 0.1, 50.0,
            'a person looks'),
        Description(
            'false_alarms', _DEFAULTS.false_alarms, '1/year', 'false alarms per valve-year that '
            'are promised at the most, on average', 1e-3, 1e5, 'one a year'),
        Description(
            'drift', _DEFAULTS.drift, '-', 'declared drift of a residual to either side, a share '
            'of travel or supply pressure', 0.0, 1.0, 'docs/twin.md'),
        Description(
            'drift_of_reversal', _DEFAULTS.drift_of_reversal, '-', 'the same of what differs '
            'between up and down', 0.0, 1.0, 'docs/twin.md'),
        Description(
            'drift_of_spread', _DEFAULTS.drift_of_spread, '-', 'the same of the logarithm of the '
            'scatter', 0.0, 10.0, 'docs/twin.md'),
        Description(
            'block', _DEFAULTS.block, 's', 'length of the blocks that are judged', 0.5, 3600.0,
            'several moves of a valve'),
        Description(
            'learning', _DEFAULTS.learning, 's', 'time in which a healthy valve shows how it is',
            10.0, 1e7, 'docs/twin.md'),
        Description(
            'memory', '', '-', 'file in which calibration and adopted model are kept over a '
            'restart; empty: none', -1.0, 1.0, 'none'),
        Description(
            'reports', '', '-', 'folder in which each diagnosis has one of its own; empty: '
            'nothing is diagnosed', -1.0, 1.0, 'none'),
        Description(
            'history', 300.0, 's', 'length of the record that is kept and diagnosed', 10.0, 3600.0,
            'several moves of a valve'),
        Description(
            'hypotheses', '', '-', 'effects that a diagnosis tries, names with blanks between '
            'them; empty: all', -1.0, 1.0, 'all'),
        Description(
            'diagnosis_timeout', 1800.0, 's', 'longest time of a diagnosis', 1.0, 86400.0,
            'docs/twin.md'),
        Description(
            'trial', 300.0, 's', 'length of the comparison of a found model with the one before',
            5.0, 86400.0, 'as the record'),
        Description(
            'adopt_confirmed', False, '-', 'adopt a found model without being asked where all '
            'that it adds is confirmed', 0.0, 1.0, 'a person decides'),
        Description(
            'adopt_into', '', '-', 'name of a running positioner that is given a found model as '
            'well; empty: none', -1.0, 1.0, 'none'),
    )
}
"""Every parameter of the twin by name."""


class AnswerSettings(NamedTuple):
    """What is done about an alarm."""

    reports: str
    history: float
    hypotheses: tuple[str, ...]
    diagnosis_timeout: float
    trial: float
    adopt_confirmed: bool
    adopt_into: str


class TwinSettings(NamedTuple):
    """The parameters of the twin, checked."""

    model: str
    store: str
    memory: str
    rate: float
    alarms: Settings
    answers: AnswerSettings


def checked(name: str, value: Any) -> Any:
    """Return one value as ROS 2 holds it; ParameterError where name, kind or range is wrong."""
    if name not in DESCRIPTIONS:
        raise ParameterError(unknown_name(name, DESCRIPTIONS))
    return checked_as(DESCRIPTIONS[name], value)


def check(values: Mapping[str, Any]) -> TwinSettings:
    """Return all settings; ParameterError, one sentence, for one that cannot be used."""
    known = {name: checked(name, values.get(name, one.default))
             for name, one in DESCRIPTIONS.items()}
    for name in values:
        checked(name, values[name])
    if known['learning'] < 24.0 * known['block']:
        raise ParameterError(
            f'learning ({known["learning"]:g} s) must be at least 24 blocks of '
            f'{known["block"]:g} s')
    known['hypotheses'] = tuple(known['hypotheses'].split())
    for name in known['hypotheses']:
        if name not in EFFECTS:
            raise ParameterError(f'hypotheses: there is no effect {name} in the catalogue '
                                 f'(it has {", ".join(EFFECTS)})')
    answers = AnswerSettings(**{name: known.pop(name) for name in AnswerSettings._fields})
    model, store, memory, rate = (known.pop(name) for name in ('model', 'store', 'memory', 'rate'))
    return TwinSettings(model, store, memory, rate, Settings(**known), answers)
