# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names and terms without one are sought by turns, and a declared term may give way."""

from dataclasses import replace

from made_search import P, searching, seen, too_quiet

from booster_ros.diagnosis import diagnose
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.model.discrepancy import CHAMBER, KNOTS, STEM, Discrepancy


def test_terms_without_a_name_are_fitted_once_beside_a_choice(monkeypatch):
    search = searching(too_quiet(seen(P)), ())
    refit = search.refit()
    first, second = (Tried(refit, replace(refit, effects=(name,)), (refit,), {})
                     for name in ('dead_time', 'chamber_leak'))
    fitted = []

    def best_terms_of(_, tried):
        fitted.append(tried.chosen.effects[0])
        return [refit]

    monkeypatch.setattr(diagnose, 'best_terms', best_terms_of)
    monkeypatch.setattr(diagnose, 'beyond_names', lambda *_: True)
    for asked, end, expected in (
            (first, first, ['dead_time']), (first, second, ['dead_time', 'chamber_leak'])):
        def named_with(_search, _refit, _tell, beyond, asked=asked, end=end):
            beyond(asked)
            return end

        monkeypatch.setattr(diagnose, 'named', named_with)
        fitted.clear()
        assert diagnose._sought(search, refit, lambda *_: None) == (end, [refit])
        assert fitted == expected


def test_a_declared_term_that_gave_way_to_another_is_named():
    declared = P._replace(discrepancy=Discrepancy(STEM, values=(9.0,) * KNOTS))
    another = P._replace(discrepancy=Discrepancy(CHAMBER, values=(1e-6,) * KNOTS))
    assert diagnose._replaced(P, another) == diagnose._replaced(declared, declared) == ()
    (note,) = diagnose._replaced(declared, another)
    assert 'stem over time' in note
