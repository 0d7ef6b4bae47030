# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a campaign came to, as Markdown and as a page that needs no other file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from .scoring import Outcome
from .table import CASE_HEAD, SET_HEAD, case_rows, markdown, set_rows

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 }
th, td { border-bottom: 1px solid #ccc; padding: .3em .6em; text-align: left; vertical-align: top }
th { background: #f2f2f2; position: sticky; top: 0 }
td.wrong { background: #fbe0dd }
"""

_FAULTS = ('WRONG', 'failed', 'timeout')


def markdown_text(outcomes: Sequence[Outcome], planned: int, about: Mapping[str, str]) -> str:
    """Return the tables; `about` says in words by key what was run."""
    return '\n\n'.join([
        '# Campaign', _count(outcomes, planned),
        '\n'.join(f'- {key}: {text}' for key, text in about.items()),
        '## Sets', markdown(SET_HEAD, set_rows(outcomes)),
        '## Cases', markdown(CASE_HEAD, case_rows(outcomes))]) + '\n'


def html_page(outcomes: Sequence[Outcome], planned: int, about: Mapping[str, str]) -> str:
    """Return the same as HTML; what is wrong is shaded."""
    listed = ''.join(f'<li>{escape(key)}: {escape(text)}</li>' for key, text in about.items())
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Campaign</title><style>{_STYLE}</style></head>
<body><h1>Campaign</h1><p>{escape(_count(outcomes, planned))}</p><ul>{listed}</ul>
<h2>Sets</h2>{_table(SET_HEAD, set_rows(outcomes))}
<h2>Cases</h2>{_table(CASE_HEAD, case_rows(outcomes))}
</body></html>
"""


def _count(outcomes: Sequence[Outcome], planned: int) -> str:
    return f'{len(outcomes)} of {planned} cases have been run.'


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    heads = ''.join(f'<th>{escape(text)}</th>' for text in head)
    body = '\n'.join(f'<tr>{"".join(map(_cell, row))}</tr>' for row in rows)
    return f'<table><thead><tr>{heads}</tr></thead><tbody>\n{body}\n</tbody></table>'


def _cell(text: str) -> str:
    return f'<td class="wrong">{escape(text)}</td>' if text in _FAULTS else (
        f'<td>{escape(text)}</td>')
