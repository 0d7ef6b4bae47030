# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A report in a browser without a network: its plots are drawn, zoomed, hovered and printed."""

from html.parser import HTMLParser
import json
import shutil
import subprocess

from made_report import made_page
import pytest

CHROMIUM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))),
                None)

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed')

TRIED = """<script>
addEventListener('load', async () => {
  const said = {plots: drawn.length, errors: []};
  addEventListener('error', event => said.errors.push(event.message));
  const plot = document.getElementById('curves');
  said.lines = plot.querySelectorAll('.scatterlayer path.js-line').length;
  const whole = plot.layout.xaxis.range[1];
  await Plotly.relayout(plot, {'xaxis.range[0]': 0.1 * whole, 'xaxis.range[1]': 0.2 * whole});
  said.zoomed = plot._fullLayout.xaxis2.range[1] < 0.3 * whole;
  Plotly.Fx.hover(plot, {xval: 0.15 * whole, yval: 250}, ['x3y3']);
  await new Promise(done => setTimeout(done, 300));
  said.hovered = plot.querySelector('.hoverlayer').textContent;
  const before = plot._fullLayout.width;
  dispatchEvent(new Event('beforeprint'));
  said.printed = plot._fullLayout.width;
  dispatchEvent(new Event('afterprint'));
  said.asked = performance.getEntriesByType('resource').map(one => one.name);
  document.body.innerHTML = '<output></output>';
  document.querySelector('output').textContent = JSON.stringify(said);
});
</script>"""


class Said(HTMLParser):
    """What the page says of itself in the end."""

    def __init__(self, text):
        super().__init__()
        self.inside, self.text = False, ''
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.inside = tag == 'output'

    def handle_data(self, data):
        self.text += data * self.inside


def browse(folder, page, *options):
    """Return what the browser prints of a page that it opens without a network."""
    path = folder / 'report.html'
    path.write_text(page, encoding='utf-8')
    return subprocess.run(
        [CHROMIUM, '--headless', '--no-sandbox', '--disable-gpu', '--window-size=1100,900',
         f'--user-data-dir={folder / "profile"}', '--host-resolver-rules=MAP * ~NOTFOUND',
         '--virtual-time-budget=10000', *options, path.as_uri()],
        capture_output=True, text=True, timeout=120, check=True).stdout


def test_plots_are_drawn_zoomed_and_hovered_without_a_network(tmp_path):
    page = made_page('effect').replace('</body>', f'{TRIED}</body>')
    said = json.loads(Said(browse(tmp_path, page, '--dump-dom')).text)
    assert said['errors'] == []
    assert said['asked'] == []
    assert said['plots'] == 3
    assert said['lines'] >= 7  # the current, and three of each channel
    assert said['zoomed']
    assert 'measured' in said['hovered']
    assert 'kPa' in said['hovered']
    assert said['printed'] == 660


def test_a_report_is_printed(tmp_path):
    target = tmp_path / 'report.pdf'
    browse(tmp_path, made_page('effect'), '--no-pdf-header-footer', f'--print-to-pdf={target}')
    pages = target.read_bytes()
    assert pages.startswith(b'%PDF')
    assert pages.count(b'/Type /Page\n') >= 3
