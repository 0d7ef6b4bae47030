# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What may import what: the physics nothing, the diagnosis the physics, and few the nodes."""

import ast
from pathlib import Path

import pytest
from ros_process import ROOT

PACKAGE = ROOT / 'booster_ros'

MAY_IMPORT = {
    'model': set(),
    'writing': set(),
    'records': {'model', 'writing'},
    'faults': {'model'},
    'parameters': {'model', 'faults', 'writing'},
    'control': {'model', 'records', 'parameters'},
    'signals': set(),
    'numerics': set(),
    'diagnosis/data': {'model', 'records', 'signals'},
    'diagnosis/estimation': {'model', 'numerics', 'signals', 'diagnosis/data'},
    'diagnosis/hypotheses': {
        'model', 'numerics', 'records', 'signals', 'diagnosis/data', 'diagnosis/estimation'},
    'diagnosis/prepare': {'model', 'records', 'signals', 'diagnosis/data', 'diagnosis/estimation'},
    'diagnosis/selection': {'model', 'numerics', 'signals', 'diagnosis/data',
                            'diagnosis/estimation', 'diagnosis/hypotheses'},
    'diagnosis/judging': {
        'model', 'numerics', 'records', 'signals', 'diagnosis/data', 'diagnosis/estimation',
        'diagnosis/hypotheses', 'diagnosis/prepare', 'diagnosis/selection'},
    'diagnosis': {'model', 'records', 'diagnosis/data', 'diagnosis/estimation',
                  'diagnosis/hypotheses', 'diagnosis/judging', 'diagnosis/selection'},
    'report': {'model', 'records', 'parameters', 'diagnosis'},
    'metrics': {'records', 'writing'},
    'twin': {'model', 'signals', 'parameters', 'records', 'writing', 'metrics'},
    'paper': {'model', 'records', 'diagnosis/estimation', 'writing'},
    'measured': {'model', 'records', 'parameters', 'diagnosis', 'report', 'paper'},
    'nodes': {'model', 'records', 'faults', 'parameters', 'control', 'twin'},
    'testing': {'model', 'parameters', 'nodes', 'programs'},
    'running': set(),  # knows programs by name only
    'campaign': {'running'},  # judges the diagnosis as a program, of whatever state
    'fleet': {'model', 'report', 'running'},
    'programs': {'model', 'records', 'parameters', 'diagnosis', 'report', 'paper', 'campaign',
                 'fleet', 'running', 'metrics', 'twin', 'writing'},
    'benchmark': {'model', 'records', 'control', 'faults', 'programs', 'testing', 'twin'},
}
"""For each folder the others that it may import, with all that lies in them."""

BESIDE_THE_RULE = {
    # results are data that both have
    'diagnosis/judging/change_point.py': 'diagnosis',
    'diagnosis/judging/false_positive_rate.py': 'diagnosis',
    'diagnosis/judging/prediction_uncertainty.py': 'diagnosis',
    'diagnosis/judging/test_set.py': 'diagnosis',
    'diagnosis/judging/validation.py': 'diagnosis',
    'parameters/table.py': 'control',  # a page of the docs, made of the tables of both nodes
    'benchmark/node_floor.py': 'nodes',  # a node as well, which has to start as the others do
    'benchmark/twin_change.py': 'nodes',  # the twin, tick by tick with its valve
    'benchmark/twin_replay.py': 'nodes',  # and with a bag
}

ROS = {'rclpy', 'std_msgs', 'sensor_msgs', 'diagnostic_msgs', 'rcl_interfaces', 'std_srvs'}


def folder_of(path: Path) -> str:
    return path.parent.relative_to(PACKAGE).as_posix()


def imported_by(path: Path) -> list[tuple[str, ...]]:
    """Return the dotted names of all modules a file imports, wherever in it, as tuples."""
    here = path.relative_to(ROOT).parts[:-1]
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names += [tuple(alias.name.split('.')) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = here[:len(here) - node.level + 1] if node.level else ()
            base += tuple(node.module.split('.')) if node.module else ()
            names += [(*base, alias.name) for alias in node.names]
    return names


def folder_imported(name: tuple[str, ...]) -> str | None:
    """Return the folder of the package that a dotted name lies in, None for what is not ours."""
    if name[0] != PACKAGE.name:
        return None
    path = PACKAGE
    for part in name[1:]:
        if not (path / part).is_dir():
            break
        path /= part
    return path.relative_to(PACKAGE).as_posix()


def files_of(folder: str) -> list[Path]:
    return sorted((PACKAGE / folder).glob('*.py'))


def test_every_folder_has_its_rule():
    folders = {folder_of(path) for path in PACKAGE.rglob('*.py')} - {'.'}
    assert folders == set(MAY_IMPORT)


@pytest.mark.parametrize('folder', MAY_IMPORT)
def test_a_folder_imports_only_what_lies_below(folder):
    wrong = []
    for path in files_of(folder):
        allowed = {folder, *MAY_IMPORT[folder]}
        allowed.add(BESIDE_THE_RULE.get(path.relative_to(PACKAGE).as_posix(), folder))
        for name in imported_by(path):
            there = folder_imported(name)
            if there not in (None, '.') and not any(
                    there == one or (one != folder and there.startswith(f'{one}/'))
                    for one in allowed):
                wrong.append(f'{path.relative_to(ROOT)} imports {".".join(name)}')
    assert wrong == []


def test_no_two_folders_import_each_other():
    def below(folder: str) -> set[str]:
        direct = {other for other in MAY_IMPORT for one in MAY_IMPORT[folder]
                  if other == one or other.startswith(f'{one}/')}
        return direct.union(*map(below, direct))

    for folder in MAY_IMPORT:
        assert folder not in below(folder)


@pytest.mark.parametrize('folder', [
    one for one in MAY_IMPORT if one not in ('nodes', 'benchmark', 'testing')])
def test_ros_is_for_the_nodes(folder):
    assert [path.name for path in files_of(folder)
            if ROS & {name[0] for name in imported_by(path)}] == []


def test_the_physics_knows_no_files_of_others_and_prints_nothing():
    for path in files_of('model'):
        called = {node.func.id for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
                  if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
        assert not called & {'print', 'open'}, path.name
