# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The false-discovery rate over all valves of a fleet, from the evidence of each.

For a valve, the null hypothesis is that nothing is missing: the record was made by the declared
model M_0, with parameters drawn from their priors and noise of the level that was found. The Bayes
factor of another model m,

    B_m = Z(m) / Z(M_0),

is then an e-value: its mean under that hypothesis is 1, whatever the sample size (P. Grünwald, R.
de Heide and W. Koolen, JRSS B 86 (2024) 1091). The diagnosis takes the best of many models, so the
e-value of a valve is

    e = max_m w_m B_m  <=  sum_m w_m B_m,      sum_m w_m = 1,

with weights that were fixed before: a fifth to each of five classes (single effects above the stem,
single effects, pairs, triples, terms without a name), in equal parts to all models of the class,
whether they were fitted or not. So what screening left out is paid for. Only comparisons with the
refitted declared model count; what is added to a model that has an effect already says nothing of
the hypothesis.

With N valves, e-BH (R. Wang and A. Ramdas, JRSS B 84 (2022) 822) keeps the k valves of the largest
e-values, k the largest number for which the k-th is at least N / (k q). Of those that are kept, a
share of at most q is expected to lack nothing, however the valves depend on each other (a common
air supply, say). Benjamini and Hochberg's own procedure needs p-values and their independence.

What this takes for granted: evidence is Laplace's approximation, noise is estimated from the same
record, and likelihoods are tempered by over-dispersion, which makes Bayes factors less extreme but
no longer exactly those of a probability. So q is a rate of what the model can know of, not a proof.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import comb, log
from typing import Any

from ..model import discrepancy
from ..model.catalogue import EFFECTS

CLASSES = 5
"""Of models, each of which has an equal share of the weight."""

LEAST = -700.0
"""Logarithm that stands for an e-value of zero, where no model was compared."""

_TERMS = len(discrepancy.LOCATIONS) * len(discrepancy.VARIABLES)


def log_e_value(trace: Sequence[Mapping[str, Any]]) -> float:
    """
    Return log e of a valve from the `trace` of its report.

    Where no model was compared with the refitted declared one, e is 0: nothing speaks against it.
    """
    found = [step['log_evidence'] + log_weight(step['effects']) for step in trace
             if not step['against'] and step['log_evidence'] is not None]
    return max([LEAST, *found])


def log_weight(effects: Sequence[str]) -> float:
    """Return log w of a model by its effects; a name that is none is a term without one."""
    models = _TERMS
    if all(name in EFFECTS for name in effects):
        models = comb(len(EFFECTS), len(effects))
    return -log(CLASSES * models)


def kept(log_e: Sequence[float], rate: float) -> list[bool]:
    """
    Return which of N valves are discoveries at a false-discovery rate q, by e-BH.

    `log_e` are the logarithms of their e-values, shape (N,); 0 < `rate` < 1.
    """
    count = len(log_e)
    order = sorted(range(count), key=lambda place: -log_e[place])
    most = max((k for k, place in enumerate(order, 1)
                if log_e[place] >= log(count / (k * rate))), default=0)
    chosen = set(order[:most])
    return [place in chosen for place in range(count)]
