# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where reports say they are from, and their pages taken apart."""

from functools import cache
from html.parser import HTMLParser
import re

from made_diagnosis import MADE

from booster_ros.report.html_report import html_page
from booster_ros.report.provenance import Provenance

FROM = Provenance('plant.csv', 'declared.yaml')
VOID = {'meta', 'link', 'br', 'img', 'input', 'hr'}


@cache
def made_page(name: str) -> str:
    """Return the page of the diagnosis that is made under this name."""
    return html_page(MADE[name](), FROM)


class Page(HTMLParser):
    """A page taken apart: its texts, ids and what it refers to; fails where tags do not match."""

    def __init__(self, text):
        super().__init__()
        self.open, self.texts, self.ids, self.references, self.tags = [], [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            if name == 'id':
                self.ids.append(value)
            if name in ('href', 'src', 'xlink:href'):
                self.references.append(value)
            self.references += re.findall(r'url\(([^)]*)\)', value or '')
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != 'style':
            self.texts.append(' '.join(data.split()))

    @property
    def text(self):
        return ' '.join(filter(None, self.texts))
