# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The next effect: which ones are worth a fit beside those a model has, and how far each gets.

1. Screen every effect in the catalogue with the declared parameters reacting (see screening).
2. Fit the most promising a few steps from each start that screening found.
3. Fit the cheapest to their end, and bring those near the best to equal terms with it.

Where the stem sticks, effects above it are screened and fitted with the stem driven as measured
(see cascade), and only then fitted in the whole model.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.friction_start import best_friction
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.searching.candidate import (
    NEAR_NOISE, WORTH_ADDING, WORTH_EXPLAINING, Candidate, preferred_first)
from booster_ros.diagnosis.searching.cascade import search_above_friction, shows_above_the_stem
from booster_ros.diagnosis.searching.screening import (
    Screened, references, screen, strong_frequencies)
from booster_ros.diagnosis.searching.search import EVALUATIONS, Search, carried, polished
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.catalogue import EFFECTS

PROMISING = 6
FIRST_EVALUATIONS = 4
"""Effects per round that get first steps of a fit, and how many, from each of their starts."""

FINALISTS = 6
HOPELESS = 6.0
CLOSE = 3.0
"""
Fits per round that are carried to their end, and multiples of the best cost above which they are
not: HOPELESS, or CLOSE where the stem sticks, as fits are slow there. Up to CLOSE, fits are also
brought to equal terms with the best.
"""

OTHER_START = 2.0
"""Multiple of the cost of an effect's first fit above which one from another start is given up."""

AS_GOOD_ABOVE = 1.1
"""
Multiple of the least cost in the part above a stem that sticks: an effect that costs more there is
not tried in the whole model, as nothing in that part blurs which effect it is.
"""

SEEN_IN_MEANS = 0.4
"""
Share of the cost of means over slips that an effect above the stem takes away if it lasts: then it
is tried, and may be called for, though single rows hardly show it.
"""

STILL_FAR = 2.0
"""
Mean square misfit above which friction that was fitted while the effect was missing is not only
fitted further, but also sought anew.
"""

FEWEST = 3
"""
Number of effects that are fitted even if their screening looks hopeless beside the best; not those
of a stem that sticks, which are slow to fit, once another one has reached the noise.
"""


@dataclass(frozen=True, eq=False)
class _Begun:
    """
    An effect with the first steps of a fit.

    `confirmed` is as in Candidate; `lasts` says that the effect is one of those `lasting` there.
    """

    effect: str
    problem: Problem
    fit: Fit
    confirmed: bool = False
    lasts: bool = False


def extend(search: Search, parent: Candidate, tick: Callable[[], None],
           leave_out: tuple[str, ...] = (), worth: float = np.inf) -> list[Candidate]:
    """
    Return the best models with one effect more than `parent`, best first.

    Effects that screening does not bring below the cost `worth` are not fitted; those that the
    first steps do not bring below it are not fitted further.
    """
    names = [name for name in search.names if name not in (*parent.effects, *leave_out) and
             not redundant(name, parent.effects)]
    above = search_above_friction(search, parent.fit)
    if above is None:
        begun = _first_steps(parent.problem, parent.fit, names, tick, worth)
    else:
        begun = _first_steps_in_parts(search, parent, names, above, tick, worth)
    begun.sort(key=lambda b: (not b.lasts, b.fit.cost))
    ended: dict[str, _Begun] = {}
    hopeless = HOPELESS if above is None else CLOSE
    promised = min((one.fit.cost for one in begun), default=0.0)
    for one in begun[:FINALISTS]:
        first = ended.get(one.effect)
        if first is not None and one.fit.cost > OTHER_START * first.fit.cost:
            continue
        if one.fit.cost < min(hopeless * promised, worth):
            one = _carried_on(one)
        if one.effect not in ended or _better(one, ended[one.effect]):
            ended[one.effect] = one
        tick()
    _bring_to_equal_terms(ended)
    return preferred_first([
        replace(search.rate((*parent.effects, one.effect), one.problem, one.fit),
                confirmed=one.confirmed, learnt=parent.learnt,
                lasting=parent.lasting.union([one.effect] if one.lasts else []),
                fault=search.fault(one.problem, one.fit, one.effect))
        for one in ended.values()])


def _carried_on(one: _Begun) -> _Begun:
    """Return the effect fitted further, unless only single slips gain by that."""
    further = replace(one, fit=one.problem.fit(one.fit.z, evaluations=EVALUATIONS))
    return further if _better(further, one) else one


def _bring_to_equal_terms(ended: dict[str, _Begun]) -> None:
    """
    Carry on those near the best, and the best as well if one of them has come below it.

    The best would otherwise seem worse only because it was ahead when the others were carried on.
    """
    least = min((one.fit.cost for one in ended.values()), default=0.0)
    best, *near = sorted((name for name, one in ended.items() if one.fit.cost < CLOSE * least),
                         key=lambda name: ended[name].fit.cost) or ['']
    for name in near:
        ended[name] = _polished(ended[name])
    if any(ended[name].fit.cost < least for name in near):
        ended[best] = _polished(ended[best])


def _polished(one: _Begun) -> _Begun:
    return replace(one, fit=polished(one.problem, one.fit))


def _better(one: _Begun, other: _Begun) -> bool:
    """Tell whether the first of two fits of an effect is better; single slips do not decide."""
    if one.fit.sticks:
        problem = one.problem
        return problem.cost_through_slips(one.fit.z) < problem.cost_through_slips(other.fit.z)
    return one.fit.cost < other.fit.cost


def _first_steps(thin: Problem, fitted: Fit, names: list[str], tick: Callable[[], None],
                 worth: float = np.inf, few: bool = False) -> list[_Begun]:
    """Return the promising effects on top of a fit, each with the first steps of its own fit."""
    around = references(thin, thin.at(fitted.z))
    frequencies = strong_frequencies(thin, fitted.z)

    def one(name: str) -> Screened:
        found = screen(thin, around, name, frequencies, few)
        tick()
        return found

    screened = sorted(side_by_side(one, names), key=lambda s: s.cost)
    begun: list[_Begun] = []
    count = 0
    for quick in screened[:PROMISING]:
        hopeful = quick.cost < HOPELESS * screened[0].cost
        if quick.cost < worth and (hopeful or (count < FEWEST and not _waste(quick, begun))):
            begun += _from_each_start(quick)
            count += 1
        tick()
    return begun


def _from_each_start(quick: Screened) -> list[_Begun]:
    """Return the first steps from each start, unless it costs far more than the first fit."""
    begun: list[_Begun] = []
    for z, cost in zip(quick.starts, quick.costs):
        if not begun or cost < HOPELESS * begun[0].fit.cost:
            begun.append(_Begun(quick.effect, quick.problem,
                                quick.problem.fit(z, evaluations=FIRST_EVALUATIONS)))
    return begun


def _first_steps_in_parts(search: Search, parent: Candidate, names: list[str], above: Search,
                          tick: Callable[[], None], worth: float) -> list[_Begun]:
    """
    Return the promising effects where the stem sticks and slips.

    Effects above the stem are fitted there first. Effects of the stem are screened in a few sizes,
    as simulations are slow, and fitted if what screening reaches is already worth adding.
    """
    present = tuple(e for e in parent.effects if shows_above_the_stem(e))
    problem = above.joint(above.problem(), present)
    fitted = problem.fit(carried(problem, parent.fit), evaluations=EVALUATIONS)
    worth_above = worth * fitted.cost / parent.fit.cost
    upper = _first_steps(problem, fitted, [n for n in names if shows_above_the_stem(n)], tick,
                         worth_above)
    upper.sort(key=lambda b: b.fit.cost)
    excess = max(fitted.cost - problem.rows_counted(), 0.0)
    parts: list[_Begun] = []
    for name in list(dict.fromkeys(b.effect for b in upper))[:FEWEST]:
        part = next(b for b in upper if b.effect == name)
        part = replace(part, fit=part.problem.fit(part.fit.z, evaluations=EVALUATIONS))
        fall = fitted.cost - part.fit.cost
        lasts = all(shows_in_means(above.on(problem, (role,), above.thinning), fitted,
                                   above.on(part.problem, (role,), above.thinning), part.fit)
                    for role in ('fit', 'select'))
        if part.fit.cost < worth_above and (lasts or fall > WORTH_ADDING * fitted.cost):
            parts.append(replace(
                part, confirmed=fall > WORTH_EXPLAINING * excess, lasts=lasts))
    least = min((part.fit.cost for part in parts), default=0.0)
    begun: list[_Begun] = []
    for part in parts:
        if part.fit.cost < AS_GOOD_ABOVE * least:
            joint = search.joint(parent.problem, (part.effect,))
            start = carried(joint, parent.fit, part.fit)
            begun.append(replace(part, problem=joint, fit=joint.fit(
                start, evaluations=FIRST_EVALUATIONS)))
            if joint.mean_square(begun[-1].fit) > STILL_FAR:
                begun.append(replace(begun[-1], fit=joint.fit_through_slips(
                    best_friction(joint, start), evaluations=FIRST_EVALUATIONS)))
        tick()
    lower = [n for n in names if not shows_above_the_stem(n)]
    worth = min(worth, (1.0 - WORTH_ADDING) * parent.fit.cost)
    return begun + _first_steps(parent.problem, parent.fit, lower, tick, worth, few=True)


def shows_in_means(before: Problem, fitted: Fit, problem: Problem, fit: Fit) -> bool:
    """
    Tell whether an effect above a stem that slips takes away much of what lasts longer than slips.

    Smoothing the measured stem leaves more in the rows around each slip than a small leak does, but
    nothing that lasts: the leak shows in the means.
    """
    return problem.cost_of_means(fit.z) < (1.0 - SEEN_IN_MEANS) * before.cost_of_means(fitted.z)


def _waste(quick: Screened, begun: list[_Begun]) -> bool:
    """Tell whether a hopeless effect is slow to fit and another one has reached the noise."""
    reached = any(one.problem.mean_square(one.fit) < NEAR_NOISE for one in begun)
    return reached and any(
        has_dry_friction(quick.problem.parameters(z).actuator) for z in quick.starts)


def redundant(name: str, present: tuple[str, ...]) -> bool:
    """Tell whether an effect has no parameter that the present ones do not have already."""
    have = {knob.parameter for other in present for knob in EFFECTS[other].knobs}
    return all(knob.parameter in have for knob in EFFECTS[name].knobs)
