# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Every link between the pages, and to a picture, leads somewhere."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]


def headings(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as they are made where its sources are shown."""
    found = re.findall(r'^#+ (.+)$', page.read_text(encoding='utf-8'), flags=re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', text.lower()).replace(' ', '-') for text in found}


def links(page: Path) -> list[str]:
    """Return where a page's links and pictures point to within the project."""
    text = re.sub(r'^```.*?^```', '', page.read_text(encoding='utf-8'),
                  flags=re.MULTILINE | re.DOTALL)
    return [link for link in re.findall(r'\]\(([^)\s]+)\)', text) if '://' not in link]


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_to_a_file_and_a_heading(page):
    for link in links(page):
        path, _, anchor = link.partition('#')
        target = (page.parent / path).resolve() if path else page
        assert target.is_relative_to(ROOT), link
        assert target.exists(), link
        assert not anchor or anchor in headings(target), link


def test_every_page_is_reached_from_the_readme():
    reached, ahead = {PAGES[0]}, [PAGES[0]]
    while ahead:
        page = ahead.pop()
        for link in links(page):
            target = (page.parent / link.partition('#')[0]).resolve()
            if target in PAGES and target not in reached:
                reached.add(target)
                ahead.append(target)
    assert reached == set(PAGES)
