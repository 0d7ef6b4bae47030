# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A term without a name in sentences: what it is, what else it may be, what would show it."""

from dataclasses import dataclass

import numpy as np

from booster_ros.diagnosis.result import Diagnosis, Refused
from booster_ros.model import discrepancy as term
from booster_ros.model.discrepancy import Discrepancy
from booster_ros.model.ep_converter import times_as_slow
from booster_ros.report.engineering import common_scale, number, scale_of
from booster_ros.report.errors import unseen
from booster_ros.report.names import (
    channel_label, effect_label, listing, place_label, positive_is)


Array = np.ndarray

WORTH_SAYING = 0.01
"""Share of rows that go beyond what a term has been fitted to, from which on that is said."""


@dataclass(frozen=True)
class UnknownTerm:
    """A discrepancy without a name: a table over one variable in one component, SI units."""

    table: Discrepancy

    @property
    def location(self) -> str:
        """The component that it enters."""
        return term.LOCATIONS[self.table.location]

    @property
    def unit(self) -> str:
        """Unit of what it adds to that component."""
        return term.LOCATION_UNITS[self.table.location]

    @property
    def variable(self) -> str:
        """The variable that it depends on."""
        return term.VARIABLES[self.table.variable]

    @property
    def variable_unit(self) -> str:
        """Unit of the variable."""
        return term.VARIABLE_UNITS[self.table.variable]

    @property
    def memory(self) -> float | None:
        """Time over which the variable is a change, s; None where the variable is no change."""
        return self.table.memory if term.forgets(self.table) else None

    @property
    def reach(self) -> float | None:
        """Half the width of the play in which the variable is a place, N; None without a play."""
        return self.table.reach if term.has_play(self.table) else None

    @property
    def seen(self) -> tuple[float, float]:
        """The range of the variable in the record; the outermost knots lie beyond it, at zero."""
        return term.covered(self.table)

    @property
    def knots(self) -> Array:
        """Values of the variable at which the table has values of its own, shape (term.KNOTS,)."""
        return np.array(self.table.knots)

    @property
    def values(self) -> Array:
        """What the term adds at each knot, shape (term.KNOTS,), the part of a play included."""
        added = np.array(self.table.values)
        if self.reach is not None:
            added -= self.reach * np.clip(self.knots, -1.0, 1.0)
        return added


def unknown_of(diagnosis: Diagnosis) -> UnknownTerm | None:
    """Return the term without a name that was added, None without one."""
    return UnknownTerm(diagnosis.unknown) if diagnosis.unknown else None


def sentence_on_unknown(unknown: UnknownTerm) -> str:
    """Return what a term depends on, where it was seen and how it stands in the model."""
    variable, size = scale_of(unknown.variable_unit), scale_of(unknown.unit)
    if unknown.reach is not None:
        width = size.text(2.0 * unknown.reach)
        inner = unknown.values[1:-1]
        rubs = size.text(0.5 * float(inner.max() - inner.min()))
        return (
            f'What the booster opens seems to follow its force through a play {width} wide, as '
            f'where {rubs} of friction hold its diaphragms. It is in the model as a table over '
            'the place in that play.')
    largest = max((float(v) for v in unknown.values), key=abs)
    over_time = unknown.variable == 'time'
    elsewhere = ', and the model is the declared one, refitted' if over_time else ''
    return (
        f'It depends on the {channel_label(unknown.variable)}, was seen from '
        f'{variable.text(unknown.seen[0])} to {variable.text(unknown.seen[1])} '
        f'and reaches {size.text(largest)} (positive: {positive_is(unknown.location)})'
        f'{_memory(unknown)}.{_how_slow(unknown, largest)} It is in the model as a table that '
        f'fades to zero outside that range{elsewhere}.'
    )


def _memory(unknown: UnknownTerm) -> str:
    if unknown.memory is None:
        return ''
    return f'; what was is forgotten over {number(unknown.memory)} s'


def _how_slow(unknown: UnknownTerm, largest: float) -> str:
    if unknown.variable != 'back_pressure_error':
        return ''
    slow = times_as_slow(largest)
    factor, way = (slow, 'slow') if slow > 1.0 else (1.0 / slow, 'quick')
    times = f'{number(factor)} times as {way}'
    return f' At the most the converter is {times} as its time constant says.'


def unknown_rivals(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence on the terms that do as well as the one without a name, if any do."""
    return [f'A term in {listing([effect_label(one) for one in effect.confused_with], "or")} '
            'explains this record as well.'
            for effect in diagnosis.effects if effect.confused_with]


def unknown_experiment(unknown: UnknownTerm) -> str:
    """Return what would show the cause of a term without a name."""
    if unknown.variable == 'time':
        return ('record the same currents again, at another hour: what stays with the clock comes '
                'from outside, what stays with the currents from the valve')
    if unknown.variable == 'back_pressure_error':
        return ('step the control current by little and by much, up and down, with the back '
                'pressure recorded: it shows by itself how fast it comes each way')
    there = f'with the channels on both sides of {place_label(unknown.location)} recorded'
    if unknown.memory is not None:
        return (f'make one step and let it stand ten times {number(unknown.memory)} s, {there}: '
                'what creeps goes on where all else has settled')
    if unknown.reach is not None:
        return (f'let the control current rise and fall slowly over the same span, {there}: the '
                'chamber pressure over the back pressure is a loop')
    return f'vary the {channel_label(unknown.variable)} alone, {there}'


def sentences_on_refused(refused: Refused, diagnosis: Diagnosis) -> list[str]:
    """Return which term did not stand: it explains too little, or the test set refutes it."""
    place = place_label(refused.location)
    term = f'A smooth term in {place} over the {channel_label(refused.variable)}'
    guess = f'That {place} is the place is a guess.'
    if refused.error is None:
        return [f'{term} comes nearest, but explains too little of what is missing: it is not in '
                'the model.', guess]
    changes = []
    for name, error in refused.error.items():
        channel = diagnosis.held_out[name]
        before = channel.before
        scale = common_scale(channel.unit, (before, error))
        changes.append(f'{channel_label(name)} from {scale.text(before)} to {scale.text(error)}')
    goes = f'the error goes with it in {listing(changes)}' if changes else (
        'the model does not come to the end with it')
    beyond = '' if refused.beyond < WORTH_SAYING else (
        f'{100.0 * refused.beyond:.0f} % of these data go beyond the range in which it was seen, '
        'where it says nothing. ')
    return [
        f'{term} explains part of what it was fitted to, but data {unseen(diagnosis)} speak '
        f'against it: there {goes}. {beyond}It is not in the model.', guess]
