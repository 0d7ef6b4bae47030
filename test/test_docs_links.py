# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Every link between the pages, and to a picture, leads somewhere."""

from pathlib import Path
import re

import pytest
from ros_process import ROOT

PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]


def prose(page: Path) -> str:
    """Return the text of a page without what is in fences."""
    return re.sub(r'^```.*?^```', '', page.read_text(encoding='utf-8'),
                  flags=re.MULTILINE | re.DOTALL)


def headings(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as they are made where its sources are shown."""
    found = re.findall(r'^#+ (.+)$', prose(page), flags=re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', text.lower()).replace(' ', '-') for text in found}


def links(page: Path) -> list[tuple[Path, str]]:
    """Return the files and anchors that a page's links and pictures in the project point to."""
    found = re.findall(r'\]\(([^)\s#]*)#?([^)\s]*)\)', prose(page))
    return [((page.parent / path).resolve() if path else page, anchor)
            for path, anchor in found if '://' not in path]


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_to_a_file_and_a_heading(page):
    for target, anchor in links(page):
        assert target.is_relative_to(ROOT), target
        assert target.exists(), target
        assert not anchor or anchor in headings(target), (target, anchor)


def test_every_page_is_reached_from_the_readme():
    reached, ahead = {PAGES[0]}, [PAGES[0]]
    while ahead:
        linked = {target for target, _ in links(ahead.pop())} & set(PAGES) - reached
        reached |= linked
        ahead += linked
    assert reached == set(PAGES)
