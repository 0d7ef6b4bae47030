# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The test that the documentation shows runs as it stands."""

import os
import re
import subprocess
import sys

from ros_process import ROOT


def test_the_page_about_testing_runs_as_it_stands(tmp_path):
    page = (ROOT / 'docs' / 'testing.md').read_text()
    blocks = re.findall(r'```python\n(.*?)```', page, re.DOTALL)
    assert len(blocks) == 1
    (tmp_path / 'test_my_controller.py').write_text(blocks[0])
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', 'test_my_controller.py'],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, 'PYTHONPATH': str(ROOT)})
    assert done.returncode == 0, done.stdout
    assert '6 passed' in done.stdout
    assert 'sleep' not in blocks[0]
