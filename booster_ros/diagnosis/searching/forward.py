# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Steps 2 to 5 of the selection: effects are added to the declared model, one by one."""

from collections.abc import Callable
import itertools

import numpy as np

from booster_ros.diagnosis.searching.birthplace import called_for_above
from booster_ros.diagnosis.searching.candidate import (
    NEAR_NOISE, Candidate, clearly_better, clears, preferred_first)
from booster_ros.diagnosis.searching.cascade import seen_from_above
from booster_ros.diagnosis.searching.faint import PERHAPS, shown_on_every_row
from booster_ros.diagnosis.searching.next_effect import FINALISTS, PROMISING, extend
from booster_ros.diagnosis.searching.search import Search
from booster_ros.diagnosis.searching.selection import Progress, Tried, tried_of
from booster_ros.diagnosis.searching.teaching import (
    PLAUSIBLE, fitted_to_noise, taught, taught_what_it_missed)

MOST_EFFECTS = 3
MOST_BESIDE_STICKING = 2
"""
Effects in all, at the most; fewer where the stem sticks: which slip comes when hides a third one
there, and looking for it takes minutes.
"""

NEGLIGIBLE = 2e-3
"""Share of the declared model's excess over noise that idealising an effect may leave."""

WELL_EXPLAINED = 1.5
"""
Mean square misfit up to which all that is left could be noise, where nothing was chosen or
friction is idealised.
"""

SURE = 40.0
"""
Fall of the cost of the fit that an effect must bring as well where all that is left could be
noise. The best effect of the catalogue lowers the cost of a clean record by 5 to 10.
"""

MOST_ENDS = 3
"""
Number of effects that show beside a model and are then fitted to their end: they have to show
beside that model fitted to its end, too.
"""


def named(search: Search, refit: Candidate, tell: Progress,
          beyond: Callable[[Tried], bool] = lambda tried: False) -> Tried:
    """
    Carry out steps 2 to 5 of the search: add effects to the refitted declared model.

    `beyond` is asked before a third effect is looked for, and tells whether that would be in vain.
    """
    everything = [refit]
    noise = refit if _explained(refit, refit) else taught(search, refit)
    if noise is None:
        chosen = _added(search, refit, everything, tell, beyond)
    else:
        chosen = _faint(search, refit, noise, 0, everything, tell)
    return tried_of(refit, chosen, everything)


def _added(search: Search, refit: Candidate, everything: list[Candidate], tell: Progress,
           beyond: Callable[[Tried], bool]) -> Candidate:
    """Return the model with effects added, one by one, as long as that is called for."""
    chosen = parent = refit
    for level in range(MOST_EFFECTS):
        if level >= _most(chosen):
            break
        if level > 0:
            if _explained(chosen, refit):
                return _faint(search, chosen, chosen, level, everything, tell)
            sharp = _sharpened(search, chosen, refit, everything)
            chosen, parent = sharp, sharp if parent is chosen else parent
            if _explained(chosen, refit):
                break
            both = taught(search, chosen) if chosen is parent else None  # else asked before
            if both is not None:
                return _faint(search, chosen, both, level, everything, tell)
        if level == MOST_EFFECTS - 1 and beyond(tried_of(refit, chosen, everything)):
            break
        ranked = _round(search, parent, level, tell)
        everything += ranked
        adding = _adding(ranked, chosen, refit)
        if adding and not chosen.effects and fitted_to_noise(chosen):
            chosen, *ends = map(search.at_its_end, (chosen, *adding[:MOST_ENDS]))
            adding = _adding(ends, chosen, refit)
            everything += [chosen, *adding]
        if not adding:
            ranked = _all_taught(search, ranked, everything)
            adding = _adding(ranked, chosen, refit) or shown_on_every_row(search, chosen, ranked)
            everything += [one for one in adding if one not in everything]
        if adding:
            chosen = adding[0]
        elif not ranked or level + 1 - len(chosen.effects) > _patience(chosen):
            break
        parent = chosen if adding else _leading(search, chosen, ranked, everything)
    return chosen


def _leading(search: Search, chosen: Candidate, ranked: list[Candidate],
             everything: list[Candidate]) -> Candidate:
    """
    Return the model to go on from where no effect is called for.

    It has the effect that the part above the stem calls for, else it is the best of the round: of
    two missing effects, either alone may look like none, or be at a bound. What it leaves where it
    was fitted counts as much as what it leaves elsewhere, as ratios: with one of two effects, a
    model that does well in most segments may go far astray in another.
    """
    above = None if chosen.effects else called_for_above(search, chosen)
    if above is None:
        return min(ranked, key=lambda c: c.misfit * c.fitted_misfit)
    everything.append(above)
    return above


def _sharpened(search: Search, chosen: Candidate, refit: Candidate, everything: list[Candidate]
               ) -> Candidate:
    """
    Return the model better fitted before a next effect is looked for; put it in its own place.

    It is fitted to every row, and that fit is taken if it leaves noise: thinned rows blur when
    something happened (a dead time, say), and save little time compared with another round. Where
    the stem sticks, it is fitted from what is seen above the stem.
    """
    if not chosen.effects:
        return chosen
    if chosen.fit.sticks:
        sharp = seen_from_above(search, chosen)
    else:
        sharp = search.on_every_row(chosen)
        if not _explained(sharp, refit):
            return chosen
    everything[everything.index(chosen)] = sharp
    return sharp


def _faint(search: Search, found: Candidate, noise: Candidate, level: int,
           everything: list[Candidate], tell: Progress) -> Candidate:
    """
    Return `found` with one more effect that shows clearly though all could be noise, else `noise`.

    `noise` is the same model, or the same taught by the select segments, which may have taught it
    to do what the effect does.

    The level of the noise is known to some percent only. Yet what follows an effect's own trace,
    in segments it was fitted to and in those it was not, is seen all the same. Where nothing has
    been added yet, an effect need not matter much if every row shows it. Where the stem sticks,
    none is looked for beside effects: what idealised friction leaves is no noise, and that round
    takes minutes.
    """
    worth = found.fit.cost - (SURE if found.effects else PERHAPS)
    in_vain = found.effects and found.fit.sticks
    ranked = [] if in_vain else _round(search, found, level, tell, worth=worth)
    everything += ranked
    shown = _surely_better(ranked, found)
    if shown:  # short of its end, a model may lack only the further steps that another one took
        end, *ends = map(search.at_its_end, (found, *shown[:MOST_ENDS]))
        shown = _surely_better(ends, end)
        everything += shown
    if not shown:
        shown = shown_on_every_row(search, found, ranked)
        everything += shown
    if shown:
        return shown[0]
    if noise is not found:
        everything.append(noise)
    return noise


def _surely_better(ranked: list[Candidate], found: Candidate) -> list[Candidate]:
    """Return the models clearly better than `found`, of which all that is left could be noise."""
    return [one for one in ranked if not one.fault and clearly_better(one, found)
            and one.fit.cost < found.fit.cost - SURE]


def _most(chosen: Candidate) -> int:
    """Return how many effects are looked for in all."""
    return MOST_BESIDE_STICKING if chosen.fit.sticks else MOST_EFFECTS


def _patience(chosen: Candidate) -> int:
    """Return how many rounds may find nothing clear: of two effects, neither may show alone."""
    return 1 if chosen.misfit > WELL_EXPLAINED and not chosen.fit.sticks else 0


def _explained(chosen: Candidate, refit: Candidate) -> bool:
    """
    Tell whether what is left is noise.

    Where nothing has been added yet, noise must be all that is left in the fit segments as well:
    an effect may show in few segments only. Where the stem sticks, what idealising its friction
    may leave is taken for noise: no model repeats every slip, and another round takes minutes.
    """
    if chosen.fit.sticks and _idealised(chosen, refit):
        return True
    return chosen.misfit < NEAR_NOISE and chosen.prior < PLAUSIBLE and (
        bool(chosen.effects) or fitted_to_noise(chosen))


def _all_taught(search: Search, ranked: list[Candidate], everything: list[Candidate]
                ) -> list[Candidate]:
    """
    Return the models of a round, best first, some of them taught by the select segments as well.

    A model that was taught counts in place of the same model before.
    """
    learnt = []
    for one in ranked:
        better = taught_what_it_missed(search, one)
        if better is not None:
            everything.append(better)
        learnt.append(better or one)
    return preferred_first(learnt)


def _idealised(chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether so small a share is left that it may come of idealising the effects so far."""
    return bool(chosen.effects) and chosen.misfit - 1.0 < NEGLIGIBLE * (refit.misfit - 1.0)


def _adding(ranked: list[Candidate], chosen: Candidate, refit: Candidate) -> list[Candidate]:
    """
    Return the models of a round that are called for, best first.

    Of models that scores do not tell apart, the plainest may fall short of that, and the next not.
    """
    return [one for one in ranked if _adds(one, chosen, refit)]


def _adds(better: Candidate, chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether one more effect is called for: one that clears it, where little is left."""
    return not better.fault and clearly_better(better, chosen) and (
        not _idealised(chosen, refit) or clears(better, chosen))


def _round(search: Search, parent: Candidate, level: int, tell: Progress, worth: float = np.inf
           ) -> list[Candidate]:
    """Return the models with one effect more than the parent, best first; `worth` as in extend."""
    steps = len(search.names) + PROMISING + FINALISTS
    done = itertools.count(1)

    def tick() -> None:
        share = min(next(done) / steps, 1.0)
        tell(f'trying effect {level + 1}', 0.05 + 0.2 * (level + share))

    return extend(search, parent, tick, worth=worth)
