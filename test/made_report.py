# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where reports say they are from, and their pages taken apart."""

from functools import cache
from html.parser import HTMLParser
import json
import re
from unittest import mock

from made_diagnosis import MADE

from booster_ros.diagnosis.result import Diagnosis
from booster_ros.report import html_report
from booster_ros.report.html_report import html_page
from booster_ros.report.provenance import Provenance

FROM = Provenance('plant.csv', 'declared.yaml')
VOID = {'meta', 'link', 'br', 'img', 'input', 'hr'}


@cache
def made_page(name: str) -> str:
    """Return the page of the diagnosis that is made under this name."""
    return html_page(MADE[name](), FROM)


def undrawn_page(diagnosis: Diagnosis, provenance: Provenance = FROM) -> str:
    """Return the page of a diagnosis without what Matplotlib draws, most of a page's time."""
    with mock.patch.object(html_report, 'svg', return_value=''):
        return html_page(diagnosis, provenance)


def drawn_texts(part):
    """Return the texts that are drawn of a plot: titles of axes, and names in the legend."""
    if isinstance(part, list):
        return [text for one in part for text in drawn_texts(one)]
    if not isinstance(part, dict):
        return []
    own = [part[key] for key in ('text', 'name') if isinstance(part.get(key), str)]
    return own + [text for one in part.values() for text in drawn_texts(one)]


class Page(HTMLParser):
    """A page taken apart: its texts, ids and what it refers to; fails where tags do not match."""

    def __init__(self, text):
        super().__init__()
        self.open, self.texts, self.ids, self.references, self.tags = [], [], [], [], []
        self.plots, self._plot = {}, ''
        self.feed(text)
        self.close()
        assert self.open == []
        self.plots = {name: json.loads(text) for name, text in self.plots.items()}
        self.texts += [text for plot in self.plots.values() for text in drawn_texts(plot)]

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self._plot = dict(attributes).get('data-plot', '')
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
        self._plot = ''

    def handle_data(self, data):
        if self._plot:
            self.plots[self._plot] = self.plots.get(self._plot, '') + data
        elif self.open and self.open[-1] not in ('style', 'script'):
            self.texts.append(' '.join(data.split()))

    @property
    def text(self):
        return ' '.join(filter(None, self.texts))
