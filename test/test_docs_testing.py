# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The test that the documentation shows runs as it stands."""

import os
import re
import subprocess
import sys

from ros_process import ROOT


THE_FIXTURE_THAT_THE_PAGE_REPLACES = """
pytest_plugins = ['booster_ros.testing.fixtures']


def test_it_is_a_positioner_with_the_defaults(valve):
    valve.send(4e-4)
    assert valve.run(0.1)['chamber_pressure'].max() > 0.0
    assert valve.period == 0.01
"""


def test_the_page_about_testing_runs_as_it_stands(tmp_path):
    page = (ROOT / 'docs' / 'testing.md').read_text()
    blocks = re.findall(r'```python\n(.*?)```', page, re.DOTALL)
    assert len(blocks) == 1
    (tmp_path / 'test_my_controller.py').write_text(blocks[0])
    (tmp_path / 'test_defaults.py').write_text(THE_FIXTURE_THAT_THE_PAGE_REPLACES)
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '.'],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, 'PYTHONPATH': str(ROOT)})
    assert done.returncode == 0, done.stdout
    assert '7 passed' in done.stdout
    assert 'sleep' not in blocks[0]
