# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a report: suspects, effects and declared parameters."""

from dataclasses import replace

from made_diagnosis import FRICTION, friction_found
from made_report import FROM, Page

from booster_ros.diagnosis.result import Interval, Refitted, Suspect
from booster_ros.report.html_report import html_page
from booster_ros.report.tables import declared_table, effect_table, hardly_told, shown_suspects


def test_what_is_reported_is_among_the_suspects_wherever_it_ranks():
    diagnosis = friction_found()
    better = tuple(Suspect(('stem_friction', f'other_{k}'), 1.0, 'not enough') for k in range(20))
    page = html_page(replace(diagnosis, suspects=(*better, *diagnosis.suspects)), FROM)
    assert 'class="chosen"' in page
    assert 'declared model, refitted</td>' in page


def test_suspects_stand_by_their_misfit_the_choice_first():
    """Those that were lost on the way stand last."""
    misfits = (3.0, float('nan'), 0.98, 7.0, float('inf'), 1.5)
    others = [Suspect((f'other_{k}',), misfit, 'not enough') for k, misfit in enumerate(misfits)]
    chosen = Suspect(('stem_friction',), 1.02, 'chosen')
    shown = shown_suspects(replace(friction_found(), suspects=(*others[:3], chosen, *others[3:])))
    assert shown[0] == chosen
    assert [one.misfit for one in shown[1:5]] == [0.98, 1.5, 3.0, 7.0]
    assert {one.effects for one in shown[5:]} == {('other_1',), ('other_4',)}


def test_declared_parameters_say_how_far_they_were_moved():
    known = Refitted('actuator.stop_stiffness', 'N/m', 5e8, 6e8, 4.5e8, 1.5e8, 0.56, -0.37)
    free = Refitted('booster.opening_gain', 'm^2/N', 2.75e-6, 6.2e-6, 6.2e-6, None, 0.0, 0.0)
    text = declared_table((known, free), {'before': 'refitted', 'after': 'with the effect'})
    assert '+0.6 σ' in text
    assert '−0.4 σ' in text
    assert text.count('free') == 2
    assert text.count('σ') == 2


def test_declared_parameters_have_intervals_and_those_that_are_hardly_told_are_marked():
    told = Refitted('supply.pressure', 'Pa', 4e5, 4.01e5, 4.02e5, 6e3, 0.2, 0.3, False,
                    401.9e3, 402.1e3, 0.01)
    open_yet = replace(told, low=390e3, high=413e3, width=0.98)
    moved = replace(open_yet, away_after=-2.5)
    alone = replace(told, low=float('nan'), high=float('nan'), width=float('nan'))
    cornered = replace(alone, at_limit=True)
    assert [hardly_told(one) for one in (told, open_yet, moved, alone)] == [
        False, True, False, False]
    stages = {'after': 'refitted'}
    assert '401.9 to 402.1 kPa' in Page(declared_table((told,), stages)).texts
    page = Page(declared_table((open_yet,), stages))
    assert '390.0 to 413.0 kPa' in page.texts
    assert 'hardly told by this record' in page.texts
    assert '–' in Page(declared_table((alone,), stages)).texts
    assert 'at its limit' in Page(declared_table((cornered,), stages)).texts
    assert not any('hardly told' in declared_table((one,), stages) for one in (told, moved, alone))


def test_what_may_be_rigid_has_no_upper_end():
    softest = Interval(0.0, 3.3e7, 1e10, 'N/m', open_above=True)
    page = Page(effect_table(replace(
        FRICTION, parameters={'actuator.presliding_stiffness': softest})))
    assert 'none' in page.texts
    assert any(text.startswith('from 33') and text.endswith('N/mm up') for text in page.texts)
    assert not any(' to ' in text and '10' in text for text in page.texts)


def test_a_short_interval_of_a_length_is_in_one_unit():
    backlash = replace(
        FRICTION, parameters={'sensors.position_backlash': Interval(6e-5, 5e-5, 8e-5, 'm')})
    page = Page(effect_table(backlash))
    assert '50.0 to 80.0 µm' in page.texts
