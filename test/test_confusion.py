# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The confusion matrix: cells, judging, going on after an interruption, and the page."""

import re

from hidden_plant.confusion.__main__ import main
from hidden_plant.confusion.cells import GROUPS, Cell, cells_of
from hidden_plant.confusion.figure import write_matrix
from hidden_plant.confusion.judging import OUTCOMES, Found, judge
from hidden_plant.confusion.page import page, share
from hidden_plant.confusion.running import Result, Results, last_decision, run_cells
from hidden_plant.effects import EFFECTS
from hidden_plant.program import ROOT, RunError
import pytest

LEAK = Found('chamber_leak', 'chamber')
SEAT_LEAK = Found('exhaust_seat_leak', 'booster')
FRICTION = Found('stem_friction', 'stem')
UNKNOWN_IN_STEM = Found('unknown', 'stem')


@pytest.mark.parametrize(('hidden', 'found', 'outcome', 'placed'), [
    ((), (), 'right', True),
    ((), (LEAK,), 'wrong', False),
    (('chamber_leak',), (), 'none', False),
    (('chamber_leak',), (LEAK,), 'right', True),
    (('chamber_leak',), (SEAT_LEAK,), 'group', True),
    (('heat_transfer',), (Found('dead_volume_change', 'chamber', ('heat_transfer',)),),
     'group', True),
    (('heat_transfer',), (LEAK,), 'location', True),
    (('heat_transfer',), (FRICTION,), 'wrong', False),
    (('heat_transfer',), (Found('unknown', 'chamber'),), 'unknown', True),
    (('ep_drift_warm_up',), (Found('ep_drift', 'ep_converter'),), 'right', True),
    (('chamber_leak',), (LEAK, FRICTION), 'part', False),
    (('chamber_leak', 'stem_friction'), (FRICTION, LEAK), 'right', True),
    (('chamber_leak', 'stem_friction'), (FRICTION, SEAT_LEAK), 'group', True),
    (('chamber_leak', 'stem_friction'), (LEAK,), 'part', False),
    (('chamber_leak', 'stem_friction'), (UNKNOWN_IN_STEM,), 'unknown', False),
    (('spring_creep',), (UNKNOWN_IN_STEM,), 'right', True),
    (('spring_creep',), (Found('unknown', 'chamber'),), 'unknown', False),
    (('seat_jam',), (Found('seat_load', 'stem'),), 'group', True),
    (('seat_jam',), (FRICTION,), 'location', True),
])
def test_a_verdict_is_judged_against_what_was_hidden(hidden, found, outcome, placed):
    assert judge(hidden, found) == (outcome, placed)


def test_every_effect_named_as_it_is_in_its_place_is_right():
    for key, effect in EFFECTS.items():
        found = Found(effect.names[0], effect.location)
        assert judge((key,), (found,)) == ('right', True)
        assert judge((key,), (found._replace(name='nonsense', location='nowhere'),)) == (
            'wrong', False)


def test_cells_are_all_different_and_share_a_valve_over_sizes_and_noises():
    cells = cells_of(
        ['all', 'changes', 'pairs'], ['small', 'large'], [1.0, 3.0], 4, 3, 'mixed', 'samples')
    singles, pairs = len(EFFECTS), len(GROUPS['pairs'])
    assert len(cells) == 2 * (2 * (singles + pairs) + 3)
    assert len({cell.label for cell in cells}) == len(set(cells)) == len(cells)
    seeds = {}
    for cell in cells:
        case = cell.case()
        seeds.setdefault(case.seed, set()).add((cell.effect, cell.seed))
        assert case.noise == cell.noise
        assert case.effects == tuple((k, EFFECTS[k].size(cell.size)) for k in cell.keys)
    assert all(len(owners) == 1 for owners in seeds.values())
    assert len(seeds) == singles + pairs + 3


@pytest.mark.parametrize('wrong', [
    {'effects': ['chamber_lek']}, {'effects': ['none+chamber_leak']}, {'sizes': ['huge']},
    {'noises': [0.0]}, {'noises': [float('nan')]}, {'clean': 0}])
def test_unknown_cells_are_refused(wrong):
    asked = {'effects': ['all'], 'sizes': ['small'], 'noises': [1.0], 'seed': 1, 'clean': 1,
             'kind': 'mixed', 'spread': 'samples', **wrong}
    with pytest.raises(ValueError, match=r'effect|size|noise|clean'):
        cells_of(**asked)


def cells(*effects, noise=1.0):
    return [Cell(effect, 'large' if effect != 'none' else '-', noise, 1) for effect in effects]


def result(cell, *found, before=12.0, after=1.02, seconds=30.0, decision=7):
    return Result(cell, found, before, after, seconds, decision)


def test_what_was_interrupted_goes_on_with_what_is_missing(tmp_path):
    leak, friction, clean = cells('chamber_leak', 'stem_friction', 'none')
    path = tmp_path / 'results.jsonl'

    def interrupted(cell, folder):
        if cell is friction:
            raise KeyboardInterrupt
        return result(cell, LEAK)

    with pytest.raises(KeyboardInterrupt):
        run_cells([leak, friction, clean], tmp_path, Results(path), 1, lambda *_: None, interrupted)
    before = path.read_text()
    assert before.count('chamber_leak_') + before.count('\n') in (1, 2)
    path.write_text(before.splitlines()[0] + '\n' + '{"effect": "stem_fri')  # cut while written

    ran, heard = [], []

    def fails_once(cell, folder):
        ran.append(cell)
        if cell == clean:
            raise RunError('close_loop: no')
        return result(cell, FRICTION)

    failed = run_cells([leak, friction, clean], tmp_path, Results(path), 2,
                       lambda cell, ended: heard.append((cell, type(ended))), fails_once)
    assert failed == 1
    assert set(ran) == {friction, clean}
    assert set(heard) == {(friction, Result), (clean, RunError)}
    assert Results(path).of([friction, leak, clean]) == [
        result(friction, FRICTION), result(leak, LEAK)]


def test_a_result_says_on_which_state_it_was_run():
    assert last_decision('# Decisions\n\n**9. No.** A\n\n**12. Yes.** 13. is none\n') == 12
    assert last_decision((ROOT / 'docs' / 'decisions.md').read_text()) >= 88
    same = page(MADE, 9, '', '', '')
    assert 'All were run on the state of [decision 7](decisions.md).' in same
    mixed = [*MADE, result(Cell('none', '-', 1.0, 3), decision=6),
             result(Cell('dead_time', 'small', 3.0, 1), decision=6)]
    assert ('on that of [decision 7](decisions.md) 1 small at noise 1, 4 large at noise 1, '
            '1 large at noise 3, 2 clean at noise 1; on that of [decision 6](decisions.md) '
            '1 clean at noise 1, 1 small at noise 3.') in page(mixed, 9, '', '', '')


def test_a_file_of_something_else_is_refused_and_kept(tmp_path, capsys):
    (tmp_path / 'results.jsonl').write_text('{"mine": 1}\n')
    assert main(['--out', str(tmp_path), '--docs', str(tmp_path / 'page.md')]) == 2
    assert capsys.readouterr().err.count('\n') == 1
    assert (tmp_path / 'results.jsonl').read_text() == '{"mine": 1}\n'
    assert not (tmp_path / 'page.md').exists()


MADE = [
    result(Cell('chamber_leak', 'small', 1.0, 1), before=1.9, after=1.9),
    result(Cell('chamber_leak', 'large', 1.0, 1), LEAK, before=31.4),
    result(Cell('heat_transfer', 'large', 1.0, 1), FRICTION, before=8.0, after=4.0),
    result(Cell('chamber_leak', 'large', 3.0, 1), LEAK, seconds=90.0),
    result(Cell('chamber_leak+stem_friction', 'large', 1.0, 1), FRICTION),
    result(Cell('spring_creep', 'large', 1.0, 1), UNKNOWN_IN_STEM),
    result(Cell('none', '-', 1.0, 1), before=1.0, after=1.0),
    result(Cell('none', '-', 1.0, 2), FRICTION, before=1.0, after=0.99),
]


def test_the_page_shows_every_cell_with_symbol_and_errors_and_how_it_was_made():
    text = page(MADE, 9, 'python -m x --seed 1', 'figures/x.svg', 'x.jsonl')
    rows = {line.split('|')[1].strip(): [cell.strip() for cell in line.split('|')[2:-1]]
            for line in text.split('## Every cell')[1].split('## What')[0].splitlines()
            if line.startswith('|')}
    assert rows['hidden'] == ['small, noise 1', 'large, noise 1', 'large, noise 3']
    assert rows['`chamber_leak`'] == ['– 1.90 → 1.90', '● 31 → 1.02', '● 12 → 1.02']
    assert rows['`heat_transfer`'] == ['', '✕ 8.00 → 4.00', '']
    assert rows['`chamber_leak+stem_friction`'][1].startswith('◔')
    assert rows['`spring_creep`'][1].startswith('●')
    assert '| `heat_transfer` | `stem_friction` | 1 |' in text
    assert '1 of 9 runs are missing' in text
    assert 'python -m x --seed 1' in text
    assert '30 s (median), 90 s' in text
    for symbol, meaning in OUTCOMES.values():
        assert f'- {symbol} {meaning}' in text
    clean = text.split('## Clean records')[1]
    assert '| 1 | 1/2 = 50 % (9 to 91) | `stem_friction` |' in clean


def test_the_cells_of_a_page_lie_beside_it_and_the_command_goes_on_from_them(tmp_path):
    cells = cells_of(['none'], ['small'], [1.0], 7, 2, 'mixed', 'samples')
    known = Results(tmp_path / 'results.jsonl')
    for cell, found in zip(cells, [(), (LEAK,)]):
        known.add(result(cell, *found))
    command = ['--effects', 'none', '--sizes', 'small', '--noise', '1', '--clean', '2', '--seed',
               '7', '--out', str(tmp_path)]
    assert main([*command, '--docs', str(tmp_path / 'docs' / 'page.md')]) == 0
    assert '(page.jsonl)' in (tmp_path / 'docs' / 'page.md').read_text()
    (tmp_path / 'docs' / 'page.jsonl').rename(tmp_path / 'results.jsonl')
    assert Results(tmp_path / 'results.jsonl').of(cells) == known.of(cells)
    assert main([*command, '--docs', str(tmp_path / 'docs' / 'again.md')]) == 0


def test_shares_are_by_size_and_noise_with_wilsons_interval():
    short = page(MADE, 8, '', '', '').split('## In short')[1].split('## Every')[0]
    assert 'are missing' not in short
    assert '| one effect | large | 1 | 1/2 = 50 % (9 to 91) |' in short
    assert '| one effect | small | 1 | 0/1 = 0 % (0 to 79) |' in short
    assert re.search(r'\| no name in the catalogue \| large \| 1 \| 1/1 = 100 %', short)
    # Wilson (1927) for 7 of 10: (p + z²/2n ± z √(p(1-p)/n + z²/4n²)) / (1 + z²/n)
    assert share(7, 10) == '7/10 = 70 % (40 to 89)'


def test_the_figure_counts_single_effects_and_is_the_same_again(tmp_path):
    for name in ('one.svg', 'two.svg'):
        write_matrix(MADE, tmp_path / name)
    text = (tmp_path / 'one.svg').read_text()
    assert text == (tmp_path / 'two.svg').read_text()
    for word in ('chamber_leak', 'heat_transfer', 'stem_friction', 'spring_creep', 'unknown'):
        assert f'>{word}<' in text
    assert re.findall(r'>(\d+)<', text) == ['2', '1', '1', '1', '1', '1']


def test_a_figure_of_nothing_is_written_too(tmp_path):
    write_matrix([], tmp_path / 'empty.svg')
    assert (tmp_path / 'empty.svg').stat().st_size > 0
