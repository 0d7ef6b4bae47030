# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The study of intervals compares them with what was put in, and counts rightly."""

from dataclasses import replace
import re

from hidden_plant import cases, truth
from hidden_plant.cases import play
from hidden_plant.sensors import POSITION_NOISE, PRESSURE_NOISE
from interval_coverage import __main__ as program, fits, valves
from interval_coverage.__main__ import main
from interval_coverage.fits import (
    Held, declared_parameters, judged, known_intervals, levels)
from interval_coverage.page import page
from interval_coverage.valves import Drawn
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.memory import Departure

NOISE = {'chamber_pressure': PRESSURE_NOISE, 'valve_position': POSITION_NOISE}


@pytest.fixture
def short_records(monkeypatch):
    """Let records, and what comes before them, be shorter than those of the study."""
    monkeypatch.setattr(valves, 'SECONDS', 30.0)
    monkeypatch.setattr(cases, 'WARM_UP_SECONDS', 5.0)


SLIPPING = ('stem_friction', 'stem_friction_stick_slip')


@pytest.mark.campaign
@pytest.mark.parametrize('effect', ['', *(key for key in truth.SIZES if key not in SLIPPING)])
def test_the_model_with_what_was_put_in_moves_as_the_plant_does(effect):
    """So an interval that does not hold it is wrong, not the two models different."""
    drawn = Drawn(effect, 0.0, 4)
    experiment = prepare(drawn.record(), declared_parameters())
    told = declared_parameters()
    for (name, element), value in drawn.truth().items():
        told = put(told, name, value, element)
    missed, later = [], experiment.time > 10.0  # in what state it begins, the record does not say
    for side in (-1.0, 0.0, 1.0):
        start = replace(experiment.initial, departure=Departure(ep_play=side, position_play=side))
        run = experiment.predict(told, start)
        missed.append(max(
            np.sqrt(np.nanmean((run[name] - experiment.measured[name])[later]**2)) / noise
            for name, noise in NOISE.items()))
    assert min(missed) < 1.25


@pytest.mark.usefixtures('short_records')
@pytest.mark.parametrize('effect', SLIPPING)
def test_the_model_with_the_friction_put_in_slips_as_far_as_the_plant_does(effect):
    """When it slips hangs on last digits, so errors row by row say nothing."""
    drawn = Drawn(effect, 0.0, 4)
    experiment = prepare(drawn.record(), declared_parameters())
    true = drawn.truth()

    def slips(position: np.ndarray) -> float:
        return float(np.quantile(np.abs(np.diff(position)), 0.999))

    def modelled(share_of_stiction: float) -> float:
        told = declared_parameters()
        for (name, element), value in true.items():
            told = put(told, name, value, element)
        told = put(told, 'actuator.stiction', share_of_stiction * told.actuator.stiction)
        return slips(experiment.predict(told, experiment.initial)['valve_position'])

    valve, sensors, _ = drawn.valve()
    played = slips(play(valve, sensors, experiment.current)[1])
    assert modelled(1.0) == pytest.approx(played, rel=0.05)
    assert modelled(0.5) < 0.75 * played


@pytest.mark.usefixtures('short_records')
def test_what_is_drawn_is_drawn_anew_and_again():
    one, other = Drawn('chamber_leak', 0.9, 1), Drawn('chamber_leak', 0.9, 2)
    assert one.truth() == Drawn('chamber_leak', 0.0, 1).truth()
    sizes = [each.truth()['actuator.leak_area', None] for each in (one, other)]
    assert sizes[0] != sizes[1]
    record = one.record()
    np.testing.assert_array_equal(
        record['chamber_pressure'], Drawn('chamber_leak', 0.9, 1).record()['chamber_pressure'])
    left = np.diff(record['valve_position'][-200:])  # of slow noise, steps are small
    assert np.std(left) < 0.8 * POSITION_NOISE


@pytest.mark.usefixtures('short_records')
def test_an_interval_counts_as_held_where_it_holds_what_was_put_in(monkeypatch):
    drawn = Drawn('chamber_leak', 0.0, 4)
    truth = drawn.truth()
    free = free_to_refit(declared_parameters(), prepare(drawn.record(), declared_parameters()))
    assert sum((one.knob.parameter, one.element) in truth for one in free) == 11
    few = tuple(one for one in free if one.knob.parameter in (
        'actuator.dead_volume', 'actuator.bench_set', 'ep_converter.gain'))
    monkeypatch.setattr(fits, 'free_to_refit', lambda *record: few)
    known = known_intervals(drawn)
    found = {one.parameter: one for one in judged(drawn, known)}
    assert len(found) == 1 + len(few)
    assert found['actuator.leak_area'].of_effect
    assert found['actuator.leak_area'].held
    assert not found['actuator.dead_volume'].of_effect
    monkeypatch.setattr(Drawn, 'truth', lambda _: {
        **truth, ('actuator.leak_area', None): 2.0 * truth['actuator.leak_area', None]})
    again = {one.parameter: one for one in judged(drawn, known)}
    assert not again.pop('actuator.leak_area').held
    assert all(again[name].held == one.held for name, one in found.items() if name in again)


@pytest.mark.usefixtures('short_records')
def test_a_level_is_relative_to_what_the_noise_is(monkeypatch):
    monkeypatch.setattr(valves, 'SECONDS', 30.0)
    assert levels(Drawn('', 0.0, 1, 'stairs')) == pytest.approx((1.0, 1.0), abs=0.1)
    assert levels(Drawn('', 0.9, 1, 'sines')) == pytest.approx((1.0, 1.0), abs=0.3)
    assert max(levels(Drawn('', 0.9, 1, 'hops'))) < 0.5  # taken as white


def test_the_page_counts():
    def held(*parts):
        return [Held('actuator.leak_area', True, parts[0]),
                *(Held(f'booster.{k}', False, one) for k, one in enumerate(parts[1:]))]

    text = page({('chamber_leak', 0.0): [held(True, True, False), held(False, True, True)],
                 ('', 0.9): [held(True, True, True)[1:]]},
                {('stairs', 0.9): [0.8, 1.0, 1.2]}, 'python -m it')
    assert '| chamber_leak | 0 | 2 | 1 of 2 | 3 of 4 |' in text
    assert '| none | 0.9 | 1 | – | 2 of 2 |' in text
    assert re.search(r'\| \*\*all\*\* \| \| 3 \| 1 of 2: 50\.0 % .* \| 5 of 6: 83\.3 % \(', text)
    assert 'of declared parameters: `booster.1` 2 of 3, `booster.0` 3 of 3.' in text
    assert '| stairs | 0.9 | 1 | 0.82 | 1.00 | 1.18 |' in text


@pytest.mark.campaign
def test_the_command_writes_the_page_it_names(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(program, 'COLOURS', (0.9,))
    monkeypatch.setattr(program, 'ALL_COLOURS', (0.9,))
    page_file = tmp_path / 'page.md'
    assert main(['--records', '1', '--levels', '1', '--effects', 'none', '--seed', '7',
                 '--docs', str(page_file)]) == 0
    text = page_file.read_text()
    assert 'python -m interval_coverage --records 1 --levels 1 --seed 7 --effects none\n' in text
    assert re.search(r'\| none \| 0\.9 \| 1 \| – \| \d+ of 11 \|', text)
    assert main(['--records', '0']) == 2
    assert '--records, --levels and --jobs must be 1 or more' in capsys.readouterr().err
    assert main(['--docs', str(tmp_path / 'none' / 'page.md')]) == 2
    assert f'there is no folder {tmp_path / "none"}' in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(['--effects', 'creep'])
    assert 'creep is none of none, chamber_leak' in capsys.readouterr().err
