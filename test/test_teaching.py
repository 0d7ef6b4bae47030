# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the select segments alone teach, and what may be noise in them."""

from made_search import CURRENT, P, searching, seen, selected, steps_seen
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.searching.forward import named
from booster_ros.diagnosis.searching.nameless import best_terms
from booster_ros.diagnosis.searching.next_effect import extend
from booster_ros.diagnosis.searching.teaching import most_by_noise, taught

# 0.1 mA; one step opens the booster fully, in a select segment
ONE_LARGE_STEP = np.array(
    [4.3, 4.5, 4.3, 4.5, 3.4, 3.6, 3.8, 4.0, 4.2, 4.4, 4.3, 4.4, 4.3, 4.4, 4.3])


def test_what_only_the_select_segments_teach_is_nothing_missing():
    """One select segment needs the largest opening, no fit segment does: it is a little off."""
    plant = put(P, 'booster.max_area', 0.93 * P.booster.max_area)
    search = searching(steps_seen(plant, ONE_LARGE_STEP, 1.9e5, seed=4), ())
    assert next(s for s in search.segments if s.first <= 1001 < s.last).role == 'select'
    tried = selected(search)
    assert tried.refit.misfit > 1.3
    assert tried.chosen.effects == ()
    assert tried.chosen.misfit < 1.1
    assert best_terms(search, tried) == []


def test_an_effect_is_not_blamed_for_what_only_a_select_segment_teaches():
    """The same and a leak: alone it raises the error there, as the refit imitates both at once."""
    plant = put(put(P, 'booster.max_area', 0.93 * P.booster.max_area), 'actuator.leak_area', 1e-8)
    search = searching(steps_seen(plant, ONE_LARGE_STEP, 1.9e5, seed=4), ('chamber_leak',))
    tried = named(search, search.refit(), lambda *_: None)
    assert tried.chosen.effects == ('chamber_leak',)
    assert tried.chosen.misfit < 1.1
    assert tried.held_out.misfit > tried.refit.misfit
    assert tried.chosen.fit.parameters.actuator.leak_area == pytest.approx(1e-8, rel=0.2)


def test_what_few_select_segments_teach_is_noise_also_where_values_are_missing_unevenly():
    """A segment is judged by its own values: one without gaps has more than the average."""
    experiment = seen(P, current=CURRENT, seed=3)
    search = searching(experiment, ())
    refit = search.refit()
    assert taught(search, refit) is not None
    sparse = next(s for s in search.segments if s.role == 'select')
    for measured in experiment.measured.values():
        measured[sparse.first:sparse.last][np.arange(sparse.last - sparse.first) % 4 > 0] = np.nan
    refit = search.refit()
    assert search.values_held_back().min() < 0.5 * search.values_held_back().max()
    assert taught(search, refit) is not None


@pytest.mark.parametrize('values', [12, 60, 1000, 10000])
def test_noise_alone_is_noise_in_each_select_segment_however_few_values_it_has(values):
    rng = np.random.default_rng(values)
    segments = np.full(13, values)
    left = rng.chisquare(values, (2000, 13))
    beyond = np.mean((left > most_by_noise(segments)).any(axis=1))
    assert beyond < 0.02
    assert (most_by_noise(segments) < 4.0 * segments).all()
    if values >= 1000:
        assert (most_by_noise(segments) == 1.3 * segments).all()


def test_what_a_model_was_fitted_to_is_known_of_all_that_is_made_of_it():
    search = searching(seen(put(P, 'actuator.leak_area', 5e-8)), ('chamber_leak',))
    taught_refit = search.on_both(search.refit(), search.thinning)
    with_leak, = extend(search, taught_refit, lambda: None)
    for one in (with_leak, search.at_its_end(with_leak), search.at_its_end(taught_refit)):
        assert one.learnt
    assert not search.on_every_row(with_leak).learnt
