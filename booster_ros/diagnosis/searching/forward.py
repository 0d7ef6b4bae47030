# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Steps 2 to 5 of the selection: effects are added to the declared model, one by one."""

from collections.abc import Callable
import itertools

import numpy as np

from booster_ros.diagnosis.searching.birthplace import called_for_above
from booster_ros.diagnosis.searching.candidate import (
    NEAR_NOISE, Candidate, clearly_better, preferred_first)
from booster_ros.diagnosis.searching.cascade import seen_from_above
from booster_ros.diagnosis.searching.faint import PERHAPS, shown_on_every_row
from booster_ros.diagnosis.searching.next_effect import FINALISTS, PROMISING, extend
from booster_ros.diagnosis.searching.search import Search
from booster_ros.diagnosis.searching.selection import Progress, Tried, tried_of
from booster_ros.diagnosis.searching.teaching import (
    PLAUSIBLE, fitted_to_noise, taught, taught_what_it_missed)
from booster_ros.model.actuator import has_dry_friction

MOST_EFFECTS = 3
MOST_BESIDE_STICKING = 2
"""Effects in all: where the stem sticks, which slip comes when hides a third, and costs minutes."""

NEGLIGIBLE = 2e-3
"""Of the declared model's excess over noise, this share may be what idealising an effect leaves."""

WELL_EXPLAINED = 1.5
"""
Mean square misfit up to which noise could be all there is: where nothing was chosen, or friction is
idealised.
"""

SURE = 40.0
"""
Where noise could be all, an effect must lower the cost of the fit by this as well. The best of the
catalogue lowers that of a clean record by 5 to 10.
"""

MOST_ENDS = 3
"""So many effects that show beside a refit are fitted to their end, to show beside that of it."""

CLEARED = 0.3
"""Of what is left above noise, the share that an effect may leave where little was left."""


def named(search: Search, refit: Candidate, tell: Progress,
          beyond: Callable[[Tried], bool] = lambda tried: False) -> Tried:
    """
    Carry out steps 2 to 5 of the search: effects are added to the declared model refitted.

    `beyond` is asked before a third one is looked for, and tells whether that would be in vain.
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
    Return what to go on from where no effect is called for: the one above the stem, or the best.

    Of two effects either alone may look like none, or be at a bound.
    """
    above = None if chosen.effects else called_for_above(search, chosen)
    if above is None:
        return min(ranked, key=lambda c: c.score)
    everything.append(above)
    return above


def _sharpened(search: Search, chosen: Candidate, refit: Candidate, everything: list[Candidate]
               ) -> Candidate:
    """
    Return the model better fitted, in its own place, before a next effect is looked for.

    To every row, if that leaves noise: thinned rows blur when something happened, a dead time,
    say, and hardly save time beside another round. Where the stem sticks, from what is seen above
    it.
    """
    if not chosen.effects:
        return chosen
    if has_dry_friction(chosen.fit.parameters.actuator):
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
    Return `found` with an effect more that shows clearly though all could be noise, else `noise`.

    `noise` is the same model, or that as it has learnt the select segments, which may have been to
    do what the effect does.

    The level of the noise is known to some percent only; what follows an effect's own trace in
    segments it was fitted to, and in those it was not, is seen through it. Where nothing has been
    added yet an effect need not matter much, if every row shows it. Not beside effects where
    the stem sticks: what idealised friction leaves is no noise, and that round takes minutes.
    """
    worth = found.fit.cost - (SURE if found.effects else PERHAPS)
    in_vain = found.effects and has_dry_friction(found.fit.parameters.actuator)
    ranked = [] if in_vain else _round(search, found, level, tell, worth=worth)
    everything += ranked
    shown = _surely_better(ranked, found)
    if shown:  # short of its end a model misses what another one only took some steps more for
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
    """Return those that show clearly beside a model of which all that is left could be noise."""
    return [one for one in ranked if not one.fault and clearly_better(one, found)
            and one.fit.cost < found.fit.cost - SURE]


def _most(chosen: Candidate) -> int:
    """Return how many effects are looked for in all."""
    dry = has_dry_friction(chosen.fit.parameters.actuator)
    return MOST_BESIDE_STICKING if dry else MOST_EFFECTS


def _patience(chosen: Candidate) -> int:
    """Return how many rounds may find nothing clear: of two effects each alone may not show."""
    slow = has_dry_friction(chosen.fit.parameters.actuator)
    return 1 if chosen.misfit > WELL_EXPLAINED and not slow else 0


def _explained(chosen: Candidate, refit: Candidate) -> bool:
    """
    Tell whether what is left is noise.

    Where nothing has been added yet, noise must be all that is left of the fit segments as well: an
    effect may show in few segments only. Where the stem sticks, what idealising its friction may
    leave is taken for noise: no model repeats every slip, and another round takes minutes.
    """
    if has_dry_friction(chosen.fit.parameters.actuator) and _idealised(chosen, refit):
        return True
    return chosen.misfit < NEAR_NOISE and chosen.prior < PLAUSIBLE and (
        bool(chosen.effects) or fitted_to_noise(chosen))


def _all_taught(search: Search, ranked: list[Candidate], everything: list[Candidate]
                ) -> list[Candidate]:
    """
    Return the models of a round, best first, some of them taught by the select segments as well.

    What was taught counts in place of what was not.
    """
    learnt = []
    for one in ranked:
        better = taught_what_it_missed(search, one)
        if better is not None:
            everything.append(better)
        learnt.append(better or one)
    return preferred_first(learnt)


def _idealised(chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether idealising the effects so far may leave as much, beside all they explain."""
    return bool(chosen.effects) and chosen.misfit - 1.0 < NEGLIGIBLE * (refit.misfit - 1.0)


def _adding(ranked: list[Candidate], chosen: Candidate, refit: Candidate) -> list[Candidate]:
    """
    Return those of a round, best first, that are called for.

    Where scores do not tell them apart, the plainest may fall short of that and the next not.
    """
    return [one for one in ranked if _adds(one, chosen, refit)]


def _adds(better: Candidate, chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether one effect more is called for; where little is left, only if it clears that."""
    return not better.fault and clearly_better(better, chosen) and (
        not _idealised(chosen, refit) or better.misfit - 1.0 < CLEARED * (chosen.misfit - 1.0))


def _round(search: Search, parent: Candidate, level: int, tell: Progress, worth: float = np.inf
           ) -> list[Candidate]:
    """Return the models with one effect more than the parent, best first; `worth` as in extend."""
    steps = len(search.names) + PROMISING + FINALISTS
    done = itertools.count(1)

    def tick() -> None:
        share = min(next(done) / steps, 1.0)
        tell(f'trying effect {level + 1}', 0.05 + 0.2 * (level + share))

    return extend(search, parent, tick, worth=worth)
