# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a fleet came to: a table, a page, and what of it needs attention first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import importlib.util
import os
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from ..report.templating import rendered
from .false_discovery import kept
from .outcome import Outcome
from .statuses import EFFECT, GOOD, ORDER, UNKNOWN, status_of
from .work import REPORTS

CSV, PARQUET, PAGE = 'fleet.csv', 'fleet.parquet', 'fleet.html'


class Row(NamedTuple):
    """A valve with its status, and whether the false-discovery rate of the plant keeps it."""

    outcome: Outcome
    status: str
    discovery: bool

    @property
    def report(self) -> str:
        """Where the report is, from the folder of the fleet; '' where there is none."""
        return f'{REPORTS}/{self.outcome.valve}/report.html' if self.outcome.answered else ''


def rows_of(outcomes: Sequence[Outcome], rate: float) -> list[Row]:
    """Return all valves, what needs attention first, at this false-discovery rate."""
    answered = [one for one in outcomes if one.answered]
    discoveries = dict(zip((one.valve for one in answered),
                           kept([one.log_e for one in answered], rate)))
    rows = []
    for one in outcomes:
        discovery = discoveries.get(one.valve, False) and one.kind in (EFFECT, UNKNOWN)
        rows.append(Row(one, status_of(one.kind, one.standing, discovery), discovery))
    return sorted(rows, key=lambda row: (
        ORDER.index(row.status), -(row.outcome.misfit or 0.0), row.outcome.valve))


def table_values(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the rows as plain values by column; what is not known is None."""
    return [{
        'valve': one.valve, 'status': row.status, 'verdict': one.kind,
        'effects': ', '.join(one.effects), 'location': one.location, 'standing': one.standing,
        'explained': one.explained, 'misfit': one.misfit, 'left': one.left,
        'log_e': one.log_e if one.answered else None, 'discovery': row.discovery,
        'ended': one.ended, 'message': one.message, 'summary': one.summary,
        'seconds': one.seconds, 'cpu_seconds': one.cpu_seconds, 'report': row.report,
    } for row, one in ((row, row.outcome) for row in rows)]


def write_tables(folder: Path, rows: Sequence[Row], rate: float, planned: int) -> list[Path]:
    """Write table and page, each at once; return what was written. Parquet needs pyarrow."""
    import pandas as pd

    frame = pd.DataFrame(table_values(rows))
    for column in ('explained', 'misfit', 'left', 'log_e'):
        frame[column] = frame[column].astype(float)
    written = [_at_once(folder / CSV, lambda path: frame.to_csv(path, index=False))]
    if importlib.util.find_spec('pyarrow'):
        written.append(_at_once(folder / PARQUET, lambda path: frame.to_parquet(path, index=False)))
    page = page_of(rows, rate, planned)
    written.append(_at_once(folder / PAGE, lambda path: path.write_text(page, encoding='utf-8')))
    return written


def page_of(rows: Sequence[Row], rate: float, planned: int) -> str:
    """Return the page, what needs attention first, each row with a link to its report."""
    return rendered(
        'fleet.html', title='Fleet', rate=rate, planned=planned, count=len(rows),
        statuses=list(counts(rows).items()), good=GOOD,
        rows=[{**values, 'link': quote(values['report'])} for values in table_values(rows)])


def counts(rows: Sequence[Row]) -> Mapping[str, int]:
    """Return how many valves have each status."""
    return {status: sum(row.status == status for row in rows) for status in ORDER}


def _at_once(path: Path, write: Any) -> Path:
    unfinished = path.with_name(f'.{os.getpid()}.{path.name}')
    try:
        write(unfinished)
        os.replace(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)
    return path
