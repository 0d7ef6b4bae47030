# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The example of docs/your_valve.md is a valve, and the page's rules give its numbers."""

from pathlib import Path
import re

import pytest

from booster_ros.model.gas import ATMOSPHERE
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.simulation import Plant
from booster_ros.parameters.file import read_parameter_file
from booster_ros.parameters.schema import Parameters, check

TEXT = (Path(__file__).parent.parent / 'docs' / 'your_valve.md').read_text(encoding='utf-8')


@pytest.fixture
def example(tmp_path: Path) -> Parameters:
    """Return the parameters of the example."""
    path = tmp_path / 'valve.yaml'
    path.write_text(TEXT.partition('```yaml\n')[2].partition('```')[0], encoding='utf-8')
    given = read_parameter_file(path)
    return check({**given.physical, **given.node})


def test_the_flow_of_the_data_sheet_comes_out(example):
    physical = example.physical
    plant = Plant(physical)
    plant.reset(control_current=0.02)
    normal = float(re.search(r'1 Nm³/h .*\| (\S+) \|', TEXT)[1])
    assert plant.outputs().mass_flow == pytest.approx(25.0 * normal, rel=5e-3)
    absolute, warmth = physical.supply.pressure + ATMOSPHERE, physical.supply.temperature
    area = 25.0 * normal * warmth**0.5 / (0.0404 * absolute)
    assert physical.booster.max_area == pytest.approx(area, rel=5e-3)
    fully_open = physical.booster.max_area / (physical.booster.s1 * physical.booster.opening_gain)
    assert fully_open == pytest.approx(5000.0, rel=5e-3)


def test_the_current_moves_the_stem_over_its_travel(example):
    plant = Plant(example.physical)
    for current, position in ((4e-3, 0.0), (12e-3, 0.01), (20e-3, 0.02)):
        plant.advance(current, 5000)
        assert plant.outputs().valve_position == pytest.approx(position, abs=2e-5)


def test_gain_and_offset_of_a_converter_follow_from_its_range():
    rows = re.findall(r'^\| 4–20 mA to (\d+)–(\d+) kPa \| (\S+) \| (\S+) \| \[(\S+), (\S+)\] \|$',
                      TEXT, re.MULTILINE)
    assert len(rows) == 2
    for low, high, gain, offset, least, most in rows:
        assert float(offset) + 4e-3 * float(gain) == pytest.approx(1e3 * float(low))
        assert float(offset) + 2e-2 * float(gain) == pytest.approx(1e3 * float(high))
        assert float(least) <= 4e-3 < 2e-2 <= float(most)


def test_one_factor_on_areas_volume_mass_and_friction_changes_the_flow_alone(example):
    booster, actuator = example.physical.booster, example.physical.actuator
    larger = example.physical._replace(
        booster=booster._replace(
            opening_gain=2.0 * booster.opening_gain, max_area=2.0 * booster.max_area),
        actuator=actuator._replace(**{name: 2.0 * getattr(actuator, name) for name in (
            'effective_area', 'dead_volume', 'moving_mass', 'viscous_friction', 'stop_stiffness',
            'stop_damping')}))
    seen = []
    for physical in (example.physical, larger):
        plant = Plant(physical)
        plant.advance(15e-3, 300)
        seen.append(plant.outputs())
    assert seen[1].chamber_pressure == pytest.approx(seen[0].chamber_pressure, rel=1e-6)
    assert seen[1].valve_position == pytest.approx(seen[0].valve_position, rel=1e-6)
    assert seen[1].mass_flow == pytest.approx(2.0 * seen[0].mass_flow, rel=1e-6)


def test_every_parameter_that_the_page_names_exists():
    named = re.findall(r'`((?:supply|actuator|ep_converter|booster)\.\w+)`', TEXT)
    assert len(named) > 10
    assert [name for name in named if name not in DESCRIPTIONS] == []
