# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The search for what the model lacks: which named effects a record calls for.

Model: the declared model with its parameters refitted within their priors, plus at most three
named effects, two where the stem sticks. Numbered as carried out:

1. refit the declared parameters on the fit segments; where the part above the stem then lacks
   hardly anything of what the whole lacks, only what belongs to the stem or a sensor is tried (see
   birthplace);
2. screen every effect in the catalogue with the declared parameters reacting (see screening);
3. fit the most promising jointly with the declared parameters, on the fit segments, thinned (see
   next_effect);
4. leave out those whose size is not told from none, or which run into their bounds (see
   intervals), and score the others on the select segments; the score is the sum of squared scaled
   residuals, and of the squared departures of the declared parameters, scaled by their priors;
5. keep the best and go on from 2 for a second and a third effect while the score falls by more
   than one standard error (paired, over segments), by a share that matters, and by 30 % of
   what noise does not explain; where the stem sticks, what lies above it is sought with the stem
   driven as measured (see cascade). Where all that is left could be noise, from the start or
   beside what was found, an effect must lower the cost of the fit clearly as well. What an effect
   leaves on thinned rows must be left on every row, too, before a next one is looked for. Where no
   effect is called for, models that leave noise on the fit segments learn from the select segments
   what those alone show, and count with what they learnt;
6. where there are several effects, try every other one in the place of each, then leave each out;
   where there is one, and a second one explained a part of the rest, try that beside the best few
   others: the choice may have imitated both;
7. models near the choice are fitted to every row and compared once more (see rematch).

Steps 2 to 5 are in forward, 6 and 7 in backward. Where a term without a name alone leaves noise
and does clearly better, or leaves far less than several effects together, no third effect is
looked for, and steps 6 and 7 fall away (see nameless).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from booster_ros.diagnosis.searching.candidate import Candidate, why_dropped

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Tried:
    """All models that were fitted, and the one that was chosen."""

    refit: Candidate
    chosen: Candidate
    all: tuple[Candidate, ...]
    reasons: dict[frozenset[str], str]

    @property
    def held_out(self) -> Candidate:
        """The model with the chosen effects that scored best on segments it was not fitted to."""
        same = (one for one in self.all if set(one.effects) == set(self.chosen.effects))
        return min(same, key=lambda one: (one.learnt, one.score))


def tried_of(refit: Candidate, chosen: Candidate, everything: Sequence[Candidate]) -> Tried:
    """Return the models tried, each with the reason why it was not chosen."""
    reasons = {frozenset(c.effects): why_dropped(c, chosen)
               for c in sorted(everything, key=lambda c: c.score, reverse=True)}
    reasons[frozenset(chosen.effects)] = 'chosen'
    reasons[frozenset()] = 'the declared model, refitted'
    return Tried(refit, chosen, tuple(everything), reasons)
