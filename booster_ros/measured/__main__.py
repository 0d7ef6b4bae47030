# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Run `close_loop` on every measured record and write docs/measured.md and its figures anew.

    python -m booster_ros.measured

Takes minutes, most of them for the sealed chambers.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import sys

from tqdm import tqdm

from ..model.system import PositionerParameters
from ..paper import table_three
from ..paper.printed import table_3
from ..report.figure_style import styled
from ..report.view import View
from . import figures, page, supplies
from .records import CHAMBERS, FLOW_BENCH, RECORDS, ROOT, SIGNATURE, MeasuredRecord

DOCS = ROOT / 'docs'


def section(record: MeasuredRecord) -> str:
    """Return the text on a record, its figure drawn."""
    diagnosis = record.diagnosis()
    draw = figures.decay if record in CHAMBERS else (
        figures.loop if record is SIGNATURE else figures.flow_over_force)
    path = DOCS / page.figure_file(record)
    path.parent.mkdir(parents=True, exist_ok=True)
    with styled(record.name):
        draw(View(diagnosis)).savefig(
            path, format='svg', metadata={'Date': None, 'Creator': None})
    return page.section(record, diagnosis)


def main(args: Sequence[str] | None = None) -> int:
    """Write the page and its figures; return the exit status."""
    argparse.ArgumentParser(
        prog='measured', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter).parse_args(args)
    sections = [section(record) for record in tqdm(RECORDS, desc='records')]
    experiment, declared, _ = FLOW_BENCH.experiment()
    across = page.across_supplies(supplies.predictions(experiment, declared))
    printed = table_3()
    ranking = page.ranking(
        printed, table_three.played(PositionerParameters()),
        table_three.rank(table_three.measured_change(printed)))
    # what goes across the supplies belongs behind both records of Table I
    text = page.document([*sections[:2], across, *sections[2:], ranking])
    (DOCS / 'measured.md').write_text(text, encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
