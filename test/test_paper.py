# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The reproduction of the paper: its tables, its misfit, its identification."""

from pathlib import Path
import re

import numpy as np
import pytest

from booster_ros.model.booster import Booster
from booster_ros.model.system import PositionerParameters
from booster_ros.paper import flow_bench, identification
from booster_ros.paper.printed import table_1, table_3
from booster_ros.programs import paper

TABLE = table_1()


def test_table_1_is_as_printed():
    assert [series.supply_pressure for series in TABLE] == [100e3, 150e3, 200e3]
    assert sum(len(series.mass_flow) for series in TABLE) == 60
    assert [series.mass_flow.max() for series in TABLE] == [8.5, 9.5, 10.6]
    assert TABLE[1].back_pressure[0] == 97e3


def test_table_3_comes_out():
    ours = paper.step_response().indices()._asdict()
    for name, printed in table_3().items():
        assert ours[name] == pytest.approx(printed.simulated, rel=0.01), name


def test_literal_constants_miss_table_1_where_they_must():
    """Flow begins 0.37 N too early and rises too slowly; 3.28 was computed apart from this."""
    misfit = flow_bench.misfit(Booster(), TABLE)
    assert flow_bench.rms(misfit) == pytest.approx(3.28, rel=0.02)
    for series in TABLE:
        last, first, share = flow_bench.first_flow(Booster(), series)
        assert 0.37 < last < first < 0.50
        assert share > 0.7
        closed = series.mass_flow == 0.0
        assert np.all(flow_bench.bench_flow(Booster(), series)[closed] > 4.0)


def test_plateau_flow_confirms_the_unit_of_the_table():
    """The plateau is within a quarter of choked flow through Max if printed in 1e-4 kg/s."""
    for series in TABLE:
        choked = 0.0404 * 1.45e-6 * (series.supply_pressure + 101_325.0) / np.sqrt(293.15)
        assert series.mass_flow.max() * 1e-4 == pytest.approx(choked, rel=0.25)


def test_refits():
    refitted = flow_bench.fit(flow_bench.through_origin, 2, TABLE)
    assert flow_bench.rms(flow_bench.misfit(refitted, TABLE)) == pytest.approx(2.31, rel=0.02)
    assert flow_bench.left_out(flow_bench.through_origin, 2, TABLE) == pytest.approx(2.52, rel=0.02)
    preloaded = flow_bench.fit(flow_bench.with_preload, 3, TABLE)
    assert preloaded.intake_preload == pytest.approx(0.371, abs=0.01)
    assert flow_bench.rms(flow_bench.misfit(preloaded, TABLE)) == pytest.approx(1.005, rel=0.02)
    assert flow_bench.left_out(flow_bench.with_preload, 3, TABLE) == pytest.approx(1.34, rel=0.02)


@pytest.mark.parametrize(
    ('current', 'name', 'wrong'),
    [(identification.FULL_CURRENT, 'max_area', 1.7),
     (identification.PARTIAL_CURRENT, 'opening_gain', 0.5)],
)
@pytest.mark.parametrize('seed', [1, 2])
def test_identification_recovers_what_made_the_record(current, name, wrong, seed):
    truth = PositionerParameters()
    record = identification.step_record(truth, current, np.random.default_rng(seed))
    true = getattr(truth.booster, name)
    guess = truth._replace(booster=truth.booster._replace(**{name: wrong * true}))
    found = identification.identify(record, guess, name)
    assert found.value == pytest.approx(true, rel=0.01)
    assert abs(found.value - true) < 4.0 * found.deviation


def test_identification_says_when_the_volume_was_wrong():
    """Twice the volume gives twice Max and k: only the ratio is in the record."""
    truth = PositionerParameters()
    record = identification.step_record(
        truth, identification.FULL_CURRENT, np.random.default_rng(3))
    assumed = identification.scaled(truth, identification.Scaling(2.0, 2.0, 2.0, 1.0))
    found = identification.identify(record, assumed, 'max_area')
    assert found.value == pytest.approx(2.0 * truth.booster.max_area, rel=0.01)


def test_only_ratios_to_the_volume_are_determined():
    known = identification.scaling_sensitivities(PositionerParameters())
    assert np.all(known.deviations[:3] < 0.01)
    assert known.deviations[3] > 1.0
    assert np.abs(known.directions[3]) == pytest.approx(0.5, abs=1e-3)
    pressure, position = identification.largest_change(PositionerParameters(), 0.44)
    assert pressure < 0.1
    assert position < 1e-9


def test_the_program_prints_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert paper.main(['--out', str(tmp_path / 'new')]) == 0
    printed = capsys.readouterr().out
    assert re.search(r'rise time.* 6\.46 +6\.10 +6\.0', printed)
    assert 'not at all' in printed
    for name in ('table_1.png', 'identification.png'):
        assert (tmp_path / 'new' / name).stat().st_size > 10_000
        assert (tmp_path / 'new' / name).read_bytes().startswith(b'\x89PNG')


def test_a_folder_that_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / 'file').write_text('')
    assert paper.main(['--out', str(tmp_path / 'file' / 'sub')]) == 2
    assert capsys.readouterr().err.count('\n') == 1
