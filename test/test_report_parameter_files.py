# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameter files of a report are the models of the diagnosis."""

from dataclasses import replace
import re

from made_diagnosis import friction_found, unknown_found
from made_report import FROM

from booster_ros.diagnosis.result import Interval
from booster_ros.model.parameters import from_values
from booster_ros.parameters.file import read_parameter_file
from booster_ros.report.parameter_files import write_parameter_files

NODE = {'publish_rate': 50.0, 'start_paused': True, 'step_ticks': 5, 'invalid_current': 'limit',
        'current_limits': (0.0, 0.022), 'initial_state.chamber_pressure': 2e5,
        'initial_state.control_current': 0.012}


def test_the_parameter_files_are_the_models_of_the_diagnosis(tmp_path):
    for diagnosis in (friction_found(), unknown_found()):
        write_parameter_files(tmp_path, diagnosis, FROM, NODE)
        for file, model in (('positioner.yaml', diagnosis.after),
                            ('positioner_before.yaml', diagnosis.before)):
            written = read_parameter_file(tmp_path / file)
            assert from_values(written.physical) == model
            assert written.node == NODE
            assert [type(value) for value in written.node.values()] == [
                type(value) for value in NODE.values()]


def test_the_parameter_file_marks_what_was_added(tmp_path):
    write_parameter_files(tmp_path, friction_found(), FROM, {})
    after = (tmp_path / 'positioner.yaml').read_text()
    assert re.search(r'coulomb_friction: 500\.0 +# N; ADDED: stem_friction, 95 % between', after)
    diagnosis = friction_found()
    rigid = Interval(0.0, 3.3e7, 1e10, 'N/m', open_above=True)
    friction = replace(diagnosis.effects[0], parameters={'actuator.presliding_stiffness': rigid})
    write_parameter_files(tmp_path, replace(diagnosis, effects=(friction,)), FROM, {})
    after = (tmp_path / 'positioner.yaml').read_text()
    assert re.search(r'presliding_stiffness: .*stem_friction, 95 % from 3.30 × 10⁷ up', after)
    assert 'ADDED' not in (tmp_path / 'positioner_before.yaml').read_text()
