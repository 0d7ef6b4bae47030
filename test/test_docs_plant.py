# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The lines of docs/plant.md, typed as they stand, print what the page shows."""

import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys

from made_plant_export import write
import pytest
from ros_process import ROOT

from booster_ros.programs import close_loop

PAGE = (ROOT / 'docs' / 'plant.md').read_text(encoding='utf-8')
BLOCKS = re.findall(r'^```(\w*)\n(.*?)^```\n', PAGE, re.MULTILINE | re.DOTALL)
LINES = [line for kind, block in BLOCKS if not kind for line in block.splitlines()]
SHOWN = [block for kind, block in BLOCKS if kind == 'text']
DIAGNOSIS = 'python -m booster_ros close_loop '


@pytest.fixture(scope='module')
def printed(tmp_path_factory) -> dict[str, str]:
    """Return what each line but the diagnosis, which takes minutes, prints when typed."""
    place = tmp_path_factory.mktemp('plant')
    for name in ('docs/examples/fv_211.csv', 'config/closed_loop.yaml'):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    seen = {}
    for line in LINES:
        if line.startswith(DIAGNOSIS):
            continue
        command = re.sub(r'^python ', f'{shlex.quote(sys.executable)} ', line)
        done = subprocess.run(
            ['bash', '-c', command], cwd=place, capture_output=True, text=True, check=False,
            timeout=300, env={**os.environ, 'PYTHONPATH': str(ROOT)})
        assert done.returncode == 0, (line, done.stderr)
        seen[line] = done.stdout
    return seen


def test_the_figures_of_the_page_are_those_that_are_printed(printed):
    of_metrics = [text for line, text in printed.items() if ' metrics ' in line]
    assert len(of_metrics) == 2
    for text, shown in zip(of_metrics, SHOWN[:2], strict=True):
        assert [line for line in shown.splitlines() if line not in text.splitlines()] == []


def test_the_line_of_the_diagnosis_is_one():
    (line,) = [line for line in LINES if line.startswith(DIAGNOSIS)]
    options = close_loop._parser().parse_args(shlex.split(line)[4:])
    assert options.record == Path('fv_211.si.csv')


def test_the_export_is_the_one_that_its_maker_writes(tmp_path):
    write(tmp_path / 'made.csv')
    assert (tmp_path / 'made.csv').read_bytes() == (
        ROOT / 'docs' / 'examples' / 'fv_211.csv').read_bytes()
