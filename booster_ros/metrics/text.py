# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figures as a text, for people."""

from .dead_band import Bound
from .figures import Figures
from .step_response import StepResponse

HEADING = (f'{"row":>7} {"time":>9} {"step":>9} {"gain":>7} {"T_d":>7} {"T63":>7} {"T86":>7} '
           f'{"T98":>7} {"overshoot":>9} {"offset":>9}')


def text_of(figures: Figures, travel: float | None) -> str:
    """Return the figures, lengths in % of the `travel` (m) where that is given, else in mm."""
    unit = '%' if travel else 'mm'
    factor = 100.0 / travel if travel else 1e3
    lines = [f'Lengths in {"% of travel" if travel else "mm"}, times in s. Noise of the position '
             f'{factor * figures.noise:.2g} {unit}.', '', 'Steps of the set point', '']
    if figures.steps:
        lines += [HEADING, *(_step(one, factor) for one in figures.steps)]
    else:
        lines.append('none: the set point never goes from one level at once to another')
    lines += ['', f'Dead band    {_size(figures.dead_band, factor, unit)}']
    if figures.turns:
        changes = sorted(factor * one.change for one in figures.turns)
        lines.append(f'{"":13}in ramps that turn {changes[0]:.3g} to {changes[-1]:.3g} {unit} '
                     f'(rows {_rows([one.row for one in figures.turns])})')
    lines.append(f'Resolution   {_size(figures.resolution, factor, unit)}')
    if figures.hysteresis is None:
        lines.append('Hysteresis   not told: it needs settled steps up and down')
    else:
        it = figures.hysteresis
        lines.append(f'Hysteresis   {factor * it.difference:.3g} {unit}, dead band included '
                     f'({it.up} steps up, {it.down} down)')
    for cycle in figures.limit_cycles:
        lines.append(
            f'Limit cycle  {factor * cycle.amplitude:.3g} {unit} from peak to peak every '
            f'{cycle.period:.3g} s, stick-slip index {cycle.jumpiness:.2f} (rows {cycle.first} to '
            f'{cycle.last})')
    if not figures.limit_cycles:
        lines.append('Limit cycle  none at a set point that stands')
    lines += [f'Stick-slip   index {one.jumpiness:.2f} in a ramp of '
              f'{factor * one.rate:.3g} {unit}/s '
              f'(rows {one.first} to {one.last})' for one in figures.ramps]
    return '\n'.join(lines)


def _step(one: StepResponse, factor: float) -> str:
    if not one.change:
        return f'{one.first:7d} {one.time:9.2f} {factor * one.size:9.3f}   nothing moved'
    if not one.settled:
        return f'{one.first:7d} {one.time:9.2f} {factor * one.size:9.3f}   not settled'
    over = 0.0 if one.overshoot is None else 100.0 * one.overshoot
    times = ' '.join(_number(value, 7) for value in (one.dead_time, one.t63, one.t86, one.t98))
    return (f'{one.first:7d} {one.time:9.2f} {factor * one.size:9.3f} {_number(one.gain, 7)} '
            f'{times} {over:7.1f} % {factor * (one.offset or 0.0):9.3f}')


def _number(value: float | None, width: int) -> str:
    return f'{"-":>{width}}' if value is None else f'{value:{width}.3f}'


def _size(bound: Bound, factor: float, unit: str) -> str:
    """Return what steps tell of a size."""
    if not bound.rows:
        return 'not told by steps'
    parts = []
    if bound.without_motion is not None:
        parts.append(f'at least {factor * bound.without_motion:.3g} {unit}')
    if bound.with_motion is not None:
        parts.append(f'at most {factor * bound.with_motion:.3g} {unit}')
    return f'{" and ".join(parts)} (steps at rows {_rows(list(bound.rows))})'


def _rows(rows: list[int]) -> str:
    shown = ', '.join(map(str, rows[:6]))
    return f'{shown}, ...' if len(rows) > 6 else shown
