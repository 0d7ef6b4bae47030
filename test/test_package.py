# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The ROS package: built with colcon, installed, and started from where it is installed."""

import ast
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
from xml.etree import ElementTree

from conftest import LONG
import pytest
from ros_process import ROOT, RosProcess
from std_msgs.msg import Float64

from booster_ros.__main__ import PROGRAMS
from booster_ros.control import settings as controller
from booster_ros.parameters.schema import ALL_DESCRIPTIONS

# Imported module → rosdep key, where they differ.
ROSDEP_KEYS = {
    'jinja2': 'python3-jinja2',
    'matplotlib': 'python3-matplotlib',
    'numba': 'python3-numba',
    'numpy': 'python3-numpy',
    'pandas': 'python3-pandas',
    'scipy': 'python3-scipy',
    'tqdm': 'python3-tqdm',
    'yaml': 'python3-yaml',
}
# What the benchmark compares the model with, where it is installed; nothing else imports it.
PEERS = {'river', 'sksundae'}
# Whoever names `booster_ros.testing.fixtures` in a test has it; nothing else imports it.
OF_TESTS = {'pytest'}
# For bags alone, and in no distribution's packages: a release cannot depend on what pip installs.
EXTRAS = {'rosbags'}
# Needed by the launch files, which name it in substitutions and commands only.
NOT_IMPORTED = {'ros2launch'}


class Workspace:
    """A colcon workspace in which the package has been built."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.prefix = folder / 'install' / 'booster_ros'
        self.setup = folder / 'install' / 'setup.bash'

    def sourced(self, *command: str) -> list[str]:
        """Return the command as it is run in a shell that has sourced the workspace."""
        return ['bash', '-c', f'. {shlex.quote(str(self.setup))}; exec {shlex.join(command)}']

    def executable(self, name: str) -> str:
        return str(self.prefix / 'lib' / 'booster_ros' / name)


def colcon(folder: Path, verb: str, *arguments: str) -> str:
    """Run colcon in a workspace and return what it printed."""
    program = shutil.which('colcon', path=f'{Path(sys.executable).parent}:{os.environ["PATH"]}')
    assert program, 'colcon is not installed'
    done = subprocess.run(
        [program, '--log-base', 'log', verb, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope='module')
def workspace(tmp_path_factory) -> Workspace:
    folder = tmp_path_factory.mktemp('workspace')
    colcon(folder, 'build', '--paths', str(ROOT))
    return Workspace(folder)


def manifest() -> ElementTree.Element:
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def imported_modules(folder: Path) -> set[str]:
    """Return the top-level modules that the folder's Python files import by their full name."""
    modules = set()
    for path in folder.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                modules |= {alias.name.split('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                modules.add(str(node.module).split('.')[0])
    return modules


def test_what_is_imported_is_declared_and_nothing_else():
    imported = imported_modules(ROOT / 'booster_ros') | imported_modules(ROOT / 'launch')
    foreign = (imported - set(sys.stdlib_module_names) - {'booster_ros'} - PEERS - OF_TESTS
               - EXTRAS)
    needed = {ROSDEP_KEYS.get(module, module) for module in foreign} | NOT_IMPORTED
    assert needed == {element.text for element in manifest().iter('exec_depend')}


def test_a_release_depends_on_nothing_that_pip_installs():
    """Rosdep's keys of such packages end in -pip; the build farm refuses them."""
    keys = {element.text for element in manifest() if element.tag.endswith('depend')}
    assert 'rclpy' in keys
    assert [key for key in keys if key.endswith('-pip')] == []
    assert {'website', 'repository', 'bugtracker'} == {
        element.get('type') for element in manifest().iter('url')}


def test_versions_agree():
    version = manifest().findtext('version')
    assert f"version='{version}'" in (ROOT / 'setup.py').read_text()
    headings = re.findall(r'^(\S.*)\n-+$', (ROOT / 'CHANGELOG.rst').read_text(), re.MULTILINE)
    assert headings
    assert headings[0] == 'Forthcoming' or headings[0].startswith(f'{version} (')


def test_files_of_tests_that_come_first_are_there():
    assert [name for name in LONG if not (ROOT / 'test' / f'{name}.py').is_file()] == []


def test_requirements_pin_everything():
    for name in ('run', 'test'):
        lines = (ROOT / 'requirements' / f'{name}.txt').read_text().splitlines()
        unpinned = [line for line in lines if not re.fullmatch(r'[\w.-]+==[\w.]+( ; .+)?', line)]
        assert not unpinned


def test_share_holds_launch_files_and_configuration(workspace):
    share = workspace.prefix / 'share'
    assert (share / 'ament_index' / 'resource_index' / 'packages' / 'booster_ros').is_file()
    for kind in ('launch', 'config'):
        sources = {path.name for path in (ROOT / kind).iterdir() if path.is_file()}
        assert sources
        assert {path.name for path in (share / 'booster_ros' / kind).iterdir()} == sources
    assert (share / 'booster_ros' / 'package.xml').is_file()


def test_the_pages_that_descriptions_point_to_are_installed(workspace):
    share = workspace.prefix / 'share' / 'booster_ros'
    configured = [path.read_text() for path in (share / 'config').iterdir()]
    described = [description.source for table in (ALL_DESCRIPTIONS, controller.DESCRIPTIONS)
                 for description in table.values()]
    pages = set(re.findall(r'docs/\w+\.md', '\n'.join([*configured, *described])))
    assert {'docs/accuracy.md', 'docs/fake_controller.md', 'docs/node.md'} <= pages
    assert [page for page in pages if not (share / page).is_file()] == []


def test_every_program_is_an_executable_of_the_package(workspace):
    installed = {path.name for path in (workspace.prefix / 'lib' / 'booster_ros').iterdir()}
    assert installed == set(PROGRAMS)


def test_the_installed_package_holds_every_module_and_its_data(workspace, tmp_path):
    script = 'import booster_ros; print(booster_ros.__file__)'
    found = subprocess.run(
        workspace.sourced(sys.executable, '-c', script),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    installed = Path(found.stdout.strip()).parent
    assert installed.is_relative_to(workspace.prefix)
    source = ROOT / 'booster_ros'
    files = [path.relative_to(source) for path in source.rglob('*') if path.is_file()]
    missing = [path for path in files
               if '__pycache__' not in path.parts and not (installed / path).is_file()]
    assert not missing


def test_the_installed_positioner_publishes_and_ends_cleanly(workspace, ros_client):
    with RosProcess(workspace.sourced(workspace.executable('positioner'))) as node:
        positions = ros_client.receive('valve_position', Float64, count=10)
        # The stem rests on its closed stop, which gives by micrometres.
        assert all(abs(message.data) < 1e-4 for message in positions)
        assert node.interrupt() == 0, node.output


def test_colcon_test_finds_the_tests(workspace):
    one = f'--pytest-args=test/test_package.py::{test_versions_agree.__name__}'
    colcon(workspace.folder, 'test', '--paths', str(ROOT), '--return-code-on-test-failure', one)
    assert 'Summary: 1 test, 0 errors, 0 failures' in colcon(workspace.folder, 'test-result')


def test_every_argument_that_two_positioners_lists_does_something():
    """What is included in the description itself is listed as well, whatever sets it."""
    tree = ast.parse((ROOT / 'launch' / 'two_positioners.launch.py').read_text())
    described, = (node for node in tree.body if isinstance(node, ast.FunctionDef)
                  and node.name == 'generate_launch_description')
    called = {node.func.id for node in ast.walk(described)
              if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    assert 'DeclareLaunchArgument' in called
    assert 'IncludeLaunchDescription' not in called


def launch_files() -> list[Path]:
    return sorted((ROOT / 'launch').glob('*.launch.py'))


@pytest.mark.parametrize('path', launch_files(), ids=lambda path: path.name)
def test_launch_files_describe_themselves(path):
    code = compile(path.read_text(), str(path), 'exec')
    pytest.importorskip('launch_ros', reason='launch is part of a ROS 2 installation only')
    from launch import LaunchDescription

    module: dict = {}
    exec(code, module)
    description = module['generate_launch_description']()
    assert isinstance(description, LaunchDescription)
    assert description.entities


@pytest.mark.parametrize('path', launch_files(), ids=lambda path: path.name)
def test_every_launch_file_takes_the_level_of_the_log(path):
    text = path.read_text()
    assert "LaunchConfiguration('log_level')" in text or "'positioner.launch.py'" in text
    nodes = text.count("package='booster_ros',\n")  # those of others log as they like
    assert text.count("'--log-level', LaunchConfiguration('log_level')") == nodes
