# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small pieces of HTML."""

from collections.abc import Iterable, Sequence
from html import escape
import re

_BEFORE_A_UNIT = re.compile(r'(?<=\d) (?=[%×]|(?:kPa|Pa|mm|µm|m|mA|A|N|L|s|Hz)\b)')


def paragraph(text: str, kind: str = '') -> str:
    """Return a paragraph of plain text."""
    return f'<p{_class(kind)}>{_text(text)}</p>'


def bullets(texts: Iterable[str]) -> str:
    """Return a list of plain texts."""
    return '<ul>' + ''.join(f'<li>{_text(text)}</li>' for text in texts) + '</ul>'


def section(title: str, *content: str) -> str:
    """Return a titled section of markup."""
    return f'<section>\n<h2>{escape(title)}</h2>\n' + '\n'.join(filter(None, content)) + (
        '\n</section>')


def cell(text: str, detail: str = '', kind: str = '') -> str:
    """Return a table cell of plain text, with a smaller line below it."""
    below = f'<small>{_text(detail)}</small>' if detail else ''
    return f'<td{_class(kind)}>{_text(text)}{below}</td>'


def number_cell(text: str, detail: str = '') -> str:
    """Return a table cell that is aligned as a number."""
    return cell(text, detail, 'n')


def row(cells: Sequence[str], kind: str = '') -> str:
    """Return a table row of finished cells."""
    return f'<tr{_class(kind)}>{"".join(cells)}</tr>'


def table(head: Sequence[str], rows: Iterable[str], numbers_from: int = 1) -> str:
    """Return a table; heads from the given column on stand above numbers."""
    heads = ''.join(
        f'<th{_class("n" if place >= numbers_from else "")}>{escape(text)}</th>'
        for place, text in enumerate(head))
    return (f'<div class="table"><table><thead><tr>{heads}</tr></thead><tbody>'
            f'{"".join(rows)}</tbody></table></div>')


def figure(svg: str, description: str) -> str:
    """Return a figure with what it shows in words, for those who cannot see it."""
    return f'<figure role="img" aria-label="{escape(description)}">{svg}</figure>'


def _text(text: str) -> str:
    """Return plain text as markup; no line breaks between a number and what it counts."""
    return escape(_BEFORE_A_UNIT.sub('\u00a0', text))


def _class(kind: str) -> str:
    return f' class="{kind}"' if kind else ''
