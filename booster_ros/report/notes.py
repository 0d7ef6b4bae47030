# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The notes of a report: what to keep in mind of the record, of the answer, and of another one."""

from booster_ros.diagnosis.hypotheses.discrepancy import label_of
from booster_ros.diagnosis.result import Diagnosis, FoundEffect, OtherRecord
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.discrepancy import NONE
from booster_ros.model.system import depends_on_time
from booster_ros.report.unknown_term import WORTH_SAYING, unknown_of


def notes(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what was dropped, mended or assumed, and what to keep in mind of the answer."""
    other = diagnosis.other
    return (*diagnosis.notes, *_cornered(diagnosis), *filter(None, map(either, diagnosis.effects)),
            *_replaced(diagnosis),
            *(_of_other_record(diagnosis, other) if other else ()))


def _cornered(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return a sentence for each declared parameter that ended at a limit of the refit."""
    return tuple(
        f'{one.name} went from {one.given:.4g} to {one.after:.4g} {one.unit}, the end of what a '
        'refit allows: its value is no measurement, and the model may lack something else'
        for one in diagnosis.refitted if one.at_limit)


def either(effect: FoundEffect) -> str:
    """Return a sentence where each of several sizes may be none, but not all at once, else ''."""
    if effect.name not in EFFECTS:
        return ''
    sizes = [knob for knob in EFFECTS[effect.name].knobs
             if not knob.shape and knob.parameter in effect.parameters]
    intervals = [effect.parameters[knob.parameter] for knob in sizes]
    if len(sizes) < 2 or not all(
            found.holds_none(knob) for knob, found in zip(sizes, intervals)):
        return ''
    return (f'{" and ".join(knob.parameter for knob in sizes)}: each may be none, but not all: '
            'this record shows what they do together, with declared parameters beside them')


def _replaced(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return a sentence where a term without a name took the place of one that was declared."""
    had, has = diagnosis.declared.discrepancy, diagnosis.after.discrepancy
    if had.location == NONE or has == had:
        return ()
    return (f'the declared term without a name ({label_of(had.location, had.variable)}) is no '
            'longer in the model: a model holds one, and the one that was found took its place',)


def _of_other_record(diagnosis: Diagnosis, other: OtherRecord) -> tuple[str, ...]:
    return (*(f'the other record: {note}' for note in other.notes),
            *_of_other_channels(diagnosis, other), *_beyond(diagnosis, other),
            *_in_another_phase(diagnosis))


def _of_other_channels(diagnosis: Diagnosis, other: OtherRecord) -> tuple[str, ...]:
    """Return a sentence where the records are not driven by, or compared in, the same channels."""
    first = diagnosis.experiment
    if set(first.drives) == set(other.drives) and set(first.channels) == set(other.channels):
        return ()
    this, that = (f'driven by {" and ".join(one.drives) or "nothing"} and compared in '
                  f'{" and ".join(one.channels)}' for one in (other, first))
    return (f'the other record is {this}, the first is {that}',)


def _beyond(diagnosis: Diagnosis, other: OtherRecord) -> tuple[str, ...]:
    """Return a sentence where a term without a name is asked beyond the range that it has seen."""
    unknown = unknown_of(diagnosis)
    if unknown is None or other.beyond < WORTH_SAYING:
        return ()
    variable = unknown.variable.replace('_', ' ')
    return (f'{100.0 * other.beyond:.0f} % of the other record lies beyond the {variable} in which '
            'the term without a name was seen: it fades to zero there',)


def _in_another_phase(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return a sentence where what was added depends on the time since the record began."""
    if not depends_on_time(diagnosis.after) or depends_on_time(diagnosis.declared):
        return ()
    return ('what was added goes by the time since the record began: the other record is judged '
            'as if it began like the first, the supply in the same phase, the converter as cold',)
