# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a reader of the page should think of each result; every number is from the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..diagnosis.data.experiment import rmse
from ..model.scaling import in_proportion
from ..diagnosis.result import AS_GOOD_AS_MEASURED, Diagnosis, Interval
from ..model.catalogue import EFFECTS, Knob
from ..model.system import PositionerParameters
from ..paper.table_three import Suspect as IndexSuspect
from ..report.engineering import number, si_text
from ..report.names import effect_label, listing
from .records import CHAMBERS, FLOW_BENCH, FLOW_BENCH_WITHOUT_100, SIGNATURE, MeasuredRecord
from .supplies import MODELS, SPLITS, Prediction, left_out

NOTHING = 1e-4
"""Share of an effect's typical size that counts as none."""

EXACT = 1e-3
"""Mismatch up to which an effect is said to meet all numbers."""

TOWARDS = 0.9
"""Cosine from which a direction is called near."""

BENT = 4.0
"""
A decay is called bent where its slope changes, within a third of the record, by more than this many
RMS errors of the model: less than that the steps of a coarse reading make.
"""


def on(record: MeasuredRecord, diagnosis: Diagnosis) -> list[str]:
    """Return sentences on one record."""
    own: dict[MeasuredRecord, Callable[[Diagnosis], list[str]]] = {
        FLOW_BENCH: _on_flow_bench, FLOW_BENCH_WITHOUT_100: _on_flow_bench,
        SIGNATURE: _on_signature, **dict.fromkeys(CHAMBERS, _on_chamber)}
    return [*_on_noise(diagnosis), *own[record](diagnosis), *_on_ends(diagnosis),
            *_on_sizes(diagnosis)]


def _on_noise(diagnosis: Diagnosis) -> list[str]:
    ratios = [error.after / error.noise for error in diagnosis.held_out.values()]
    if max(ratios) <= AS_GOOD_AS_MEASURED:
        return []
    found = {'effect': 'this is the best of the named explanations, not a complete one',
             'unknown': 'the term without a name is not all that is missing',
             'none': 'something is missing that nothing tried explains'}
    return [f'What is left of the held-out rows is {number(max(ratios), 2)} times the noise: '
            f'{found[diagnosis.verdict]}.']


def _on_ends(diagnosis: Diagnosis) -> list[str]:
    """Return which declared parameters ended where a refit has to end."""
    return [
        f'`{one.name}` went from {si_text(one.given, one.unit, 4)} to '
        f'{si_text(one.after, one.unit, 4)}, the end of what a refit allows: that value is no '
        'measurement, and the model may lack something else.'
        for one in diagnosis.refitted if one.at_limit]


def _on_sizes(diagnosis: Diagnosis) -> list[str]:
    """Return which sizes of the effects the record does not tell from none."""
    silent = []
    for effect in diagnosis.effects:
        for parameter, interval in effect.parameters.items():
            knob = knob_of(effect.name, parameter, diagnosis.declared)
            if knob.shape:
                continue
            if interval.holds_none(knob):
                silent.append(f'`{parameter}`')
    return [f'The record does not tell {listing(silent)} from none.'] if silent else []


def knob_of(effect: str, parameter: str, declared: PositionerParameters) -> Knob:
    """Return what turns this parameter of an effect in such a valve."""
    return next(in_proportion(knob, declared) for knob in EFFECTS[effect].knobs
                if knob.parameter == parameter)


def is_none(knob: Knob, interval: Interval) -> bool:
    """Tell whether a size and its whole interval are nothing beside a typical size."""
    nothing = NOTHING * abs(knob.typical - knob.neutral)
    return not knob.shape and all(
        abs(end - knob.neutral) < nothing for end in (interval.low, interval.value, interval.high))


def _on_flow_bench(diagnosis: Diagnosis) -> list[str]:
    supply = diagnosis.experiment.pinned['supply_pressure']
    each = [
        f'{rmse(measured, diagnosis.runs["after"]["mass_flow"], supply == at) * 1e4:.2f} at '
        f'{at / 1e3:.0f} kPa'
        for measured in [diagnosis.experiment.measured['mass_flow']] for at in np.unique(supply)]
    steep = any(one.name == 'booster.opening_gain' and one.at_limit for one in diagnosis.refitted)
    k, area = diagnosis.after.booster.opening_gain, diagnosis.after.booster.max_area
    return [
        f'By supply pressure it misses by {listing(each)}, in table units.',
        f'Opening gain and largest area, free on a flow bench, become {si_text(k, "m^2/N")} and '
        f'{si_text(area, "m^2")}' + (
            ': what resists the opening is the added effect alone.' if steep else '.'),
        'The outlet is open in all of Table I, so a force that grows with the supply pressure and '
        'one that grows with the drop across the seat look the same.']


def _on_signature(diagnosis: Diagnosis) -> list[str]:
    actuator = diagnosis.after.actuator
    width = actuator.coulomb_friction / actuator.effective_area
    return [
        'The source does not state the area of this unit: what was measured is a pressure, '
        f'{si_text(width, "Pa")} from the middle of the loop to either branch, and the friction in '
        'N is as sure as the assumed area.',
        'A sweep without time says nothing of speed.']


def _on_chamber(diagnosis: Diagnosis) -> list[str]:
    name = 'chamber_pressure'
    time, measured = diagnosis.experiment.time, diagnosis.experiment.measured[name]
    seen = _slopes(time, measured)
    model = _slopes(time, diagnosis.runs['after'][name])
    sentences = [
        f'From end to end of its three thirds the pressure falls by {_each(seen)} Pa/s, in the '
        f'model by {_each(model)}.']
    change = (seen[0] - seen[-1] - model[0] + model[-1]) * float(np.ptp(time)) / 3.0
    if change > BENT * diagnosis.error[name].after:
        sentences.append(
            'So it slows down by more than an orifice does, whose flow only follows the absolute '
            'pressure. A wall that creeps, a seal that settles or the gauge could do that; this '
            'record cannot say which.')
    else:
        sentences.append('That difference is no larger than the steps in the reading can make.')
    heat = sorted((s for s in diagnosis.suspects if 'heat_transfer' in s.effects),
                  key=lambda s: len(s.effects))
    if heat:
        sentences.append(
            'Heat, air that cools after filling, was tried: ' + listing([
                f'{" + ".join(effect_label(e) for e in s.effects)} has misfit '
                f'{number(s.misfit)} ({s.reason})' for s in heat[:2]]) + '.')
    return [*sentences,
            'The readings stand still for many seconds and then step, which escaping air does not; '
            'that looks like the gauge, but the source would have to say.']


def _each(values: Sequence[float]) -> str:
    return listing([number(value) for value in values])


def _slopes(time: np.ndarray, pressure: np.ndarray) -> list[float]:
    """
    Return by how many Pa/s a pressure falls from end to end of each third.

    No line through its readings: of a staircase that counts a step in the middle half as much
    again.
    """
    ends = np.interp(time[0] + np.ptp(time) * np.arange(4) / 3.0, time, pressure)
    return (-np.diff(ends) / (np.ptp(time) / 3.0)).tolist()


def on_supplies(found: Mapping[str, Sequence[Prediction]]) -> list[str]:
    """Return sentences on the predictions across supply pressures."""
    preload, both, alone = (found[name] for name in tuple(MODELS)[1:])
    up, down = SPLITS.index(((150e3,), 200e3)), SPLITS.index(((200e3,), 150e3))
    pair = SPLITS.index(((150e3, 200e3), 100e3))
    return [
        f'Between 150 and 200 kPa a preload alone misses by {preload[up].predicted:.2f} and '
        f'{preload[down].predicted:.2f}; where only the flow force resists the opening, by '
        f'{alone[up].predicted:.2f} and {alone[down].predicted:.2f}.',
        'With gain and flow force both free, one supply pressure cannot share the slope out '
        'between them, so that model needs two.',
        f'On 150 and 200 kPa together it leaves {both[pair].fitted:.2f} when fitted from many '
        'starts, the best that `close_loop` could have come to above.',
        'The 100 kPa series follows from none of them, and with it in, the best model changes: '
        f'over all three the preload alone is ahead ({left_out(list(preload)):.2f}).'
        if left_out(list(preload)) < left_out(list(both)) else
        'Over all three supplies the flow force is ahead as well.']


def on_ranking(helpful: Sequence[IndexSuspect]) -> list[str]:
    """Return sentences on the ranking of effects by Table III."""
    exact = [effect_label(one.name) for one in helpful if one.free >= 3 and one.mismatch < EXACT]
    near = [effect_label(one.name) for one in helpful if one.free < 3 and one.cosine > TOWARDS]
    sentences = [
        '**Three scalars cannot decide.** They say which effects point the right way, not which '
        'one is there, and two effects together can give any three numbers.']
    if exact:
        sentences.append(
            'With as many sizes as there are numbers, meeting all of them is no evidence: '
            f'{listing(exact)}.')
    if near:
        sentences.append(
            f'Of those with one or two sizes, {listing(near)} point within '
            f'{np.degrees(np.arccos(TOWARDS)):.0f}° of the wanted change, and all of them leave '
            f'at least {min(one.mismatch for one in helpful if one.free < 3):.1%}.')
    return [*sentences,
            'What would decide is the record behind the table: pressure over time at the booster '
            'outlet and in the chamber, with the stem position, for steps up and down of several '
            'sizes. A tube shows between the two pressures, a spring in position over pressure, a '
            'dead volume below the pressure at which the stem starts.']
