# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML."""

import pytest

from booster_ros.report.markup import bullets, cell, paragraph


@pytest.mark.parametrize(('text', 'kept'), [
    ('less than 1 % after', 'less than 1\u00a0% after'),
    ('from 5.06 kPa to 9 µm (1.3 × noise)', 'from 5.06\u00a0kPa to 9\u00a0µm (1.3\u00a0× noise)'),
    ('2 seats, 3 mistakes, at 4 s', '2 seats, 3 mistakes, at 4\u00a0s')])
def test_a_number_stays_on_the_line_of_its_unit(text, kept):
    """No line breaks between them, in all kinds of text."""
    for markup in (paragraph(text), bullets([text]), cell(text), cell('', text)):
        assert kept in markup


def test_text_is_never_taken_for_markup():
    """A channel's name may hold any character."""
    assert '&lt;b&gt; &amp; 1\u00a0%' in paragraph('<b> & 1 %')
