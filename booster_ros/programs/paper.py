# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reproduce the paper's Tables III and I and the two identification steps of its section III."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from pathlib import Path
import sys

import numpy as np

from ..legible import legible
from ..model.booster import Booster
from ..model.simulation import simulate
from ..model.system import PositionerParameters
from ..paper import flow_bench, identification
from ..paper.comparison import comparison
from ..paper.figures import draw_flow_bench, draw_identification
from ..paper.printed import FlowSeries, table_1, table_3
from ..paper.step_test import RESPONSE, STEP_CURRENT, StepResponse
from ..surroundings import INTERRUPTED
from .compiling import announce_compilation
from .interruption import kept_interruption
from .path_argument import given_path
from .telling import complain

SEED = 20170
"""Seed of the noise on the simulated records: the same numbers at every run."""

WRONG_GAIN, WRONG_AREA = 0.6, 1.6
"""Factors on the true gain and area at which the identification starts."""

PRINTED_GAIN, PRINTED_AREA = 2.75e-6, 1.45e-6
"""k in m²/N (printed 0.275e-11 m²/(Pa mm²)) and Max in m², section III."""


def main(args: Sequence[str] | None = None) -> int:
    """Print the reproduction, draw it where asked to; return the exit status."""
    parser = argparse.ArgumentParser(
        prog='paper',
        description=(__doc__ or '') + " Prints the paper's numbers beside ours.")
    parser.add_argument('--out', type=given_path, help='folder for the plots (default: no plots)')
    out: Path | None = parser.parse_args(args).out
    with kept_interruption() as check:
        try:
            if out is not None:
                out.mkdir(parents=True, exist_ok=True)
            announce_compilation()
            for report in (report_table_3, partial(report_table_1, out),
                           partial(report_identification, out)):
                report()
                check()
        except OSError as error:
            complain('paper', f'{error.filename or out}: {error.strerror}')
            return 2
        except KeyboardInterrupt:
            complain('paper', 'interrupted')
            return INTERRUPTED
    return 0


def step_response() -> StepResponse:
    """Return the declared positioner's answer to 0 → 0.4524 mA, from rest."""
    time = np.arange(round(RESPONSE / 1e-3) + 1) * 1e-3
    run = simulate(
        PositionerParameters(), time, np.full_like(time, STEP_CURRENT), {'back_pressure': 0.0})
    return StepResponse(time, run['chamber_pressure'])


def report_table_3() -> None:
    """Print the indices of the step response beside the paper's."""
    print('TABLE III  step 0 → 0.4524 mA\n')
    print(comparison([step_response().indices()], table_3()))
    print(
        '\nOf the model, diaphragm area, dead volume and E/P lag were chosen so that this column\n'
        "comes out: it shows that the corrected equations are the paper's, not that they are "
        'right.\n')


def report_table_1(out: Path | None) -> None:
    """Print the virtual bench beside Table I, literal and refitted, and say what is wrong."""
    table = table_1()
    literal = Booster()
    refitted = flow_bench.fit(flow_bench.through_origin, 2, table)
    preloaded = flow_bench.fit(flow_bench.with_preload, 3, table)
    print('TABLE I  flow of the booster, supply fixed, back pressure swept, outlet open')
    print('         printed flow read as 1e-4 kg/s; RMS misfit in units of the table\n')
    print(misfit_table(table, {
        "the paper's k and Max": (literal, None),
        'k, Max refitted': (refitted, flow_bench.left_out(flow_bench.through_origin, 2, table)),
        'k, Max and a preload F0': (
            preloaded, flow_bench.left_out(flow_bench.with_preload, 3, table)),
    }))
    print('\nWhy S = min(k F, Max) through the origin misses:\n')
    print(f'{"supply, kPa":>12}{"no flow yet at":>18}{"flow from":>12}{"the model passes":>20}')
    for series in table:
        last, first, share = flow_bench.first_flow(literal, series)
        supply = series.supply_pressure / 1e3
        print(f'{supply:12.0f}{last:16.3f} N{first:10.3f} N{share:18.0%} of its flow')
    print(
        f'\nThe intake opens only after {preloaded.intake_preload:.2f} N, which the paper calls '
        'negligible: it put the\noutlet at 101.3 kPa where every other pressure is gauge, and that '
        'hides\n'
        f'{101.3e3 * literal.s3:.3f} N of it. The slope is then {preloaded.opening_gain:.2e} m²/N, '
        f'{preloaded.opening_gain / literal.opening_gain:.1f} times the printed one.\n')
    if out is not None:
        path = out / 'table_1.png'
        draw_flow_bench(table, {
            'k, Max as printed': literal, 'refitted': refitted, 'with preload': preloaded}, path)
        print(f'Plot: {legible(path)}\n')


def misfit_table(
    table: Sequence[FlowSeries], boosters: dict[str, tuple[Booster, float | None]]
) -> str:
    """Return RMS misfits by supply pressure, over all rows, and of a supply left out of the fit."""
    supplies = ''.join(f'{f"{series.supply_pressure / 1e3:.0f} kPa":>10}' for series in table)
    lines = [f'{"":26}{supplies}{"all":>8}{"left out":>10}{"k, m²/N":>12}{"Max, m²":>11}']
    for label, (booster, left_out) in boosters.items():
        each = ''.join(
            f'{flow_bench.rms(flow_bench.misfit(booster, [series])):10.2f}' for series in table)
        whole = flow_bench.rms(flow_bench.misfit(booster, table))
        apart = '-' if left_out is None else f'{left_out:.2f}'
        lines.append(
            f'{label:26}{each}{whole:8.2f}{apart:>10}{booster.opening_gain:12.2e}'
            f'{booster.max_area:11.2e}')
    return '\n'.join(lines)


def report_identification(out: Path | None) -> None:
    """Run both steps on simulated records with noise and print what they find."""
    declared = PositionerParameters()
    random = np.random.default_rng(SEED)
    full = identification.step_record(declared, identification.FULL_CURRENT, random)
    small = identification.step_record(declared, identification.PARTIAL_CURRENT, random)
    guess = declared._replace(booster=declared.booster._replace(
        opening_gain=WRONG_GAIN * declared.booster.opening_gain,
        max_area=WRONG_AREA * declared.booster.max_area))
    print('SECTION III  identification on simulated records (150 Pa, 8 µm RMS of noise)\n')
    print(f'{"":26}{"printed":>12}{"first guess":>13}{"identified":>13}{"off":>9}{"1 sigma":>9}')
    p = guess
    for turn in ('first', 'second'):
        area = identification.identify(full, p, 'max_area')
        p = p._replace(booster=p.booster._replace(max_area=area.value))
        print(identified_line(f'Max, 0 → 1.16 mA, {turn}', PRINTED_AREA, guess.booster.max_area,
                              area))
        gain = identification.identify(small, p, 'opening_gain')
        p = p._replace(booster=p.booster._replace(opening_gain=gain.value))
        print(identified_line(f'k, 0 → 0.4292 mA, {turn}', PRINTED_GAIN,
                              guess.booster.opening_gain, gain))
    print(
        f'\nThreshold Max/k: printed 5.31e5 Pa mm² = 0.531 N, ours '
        f'{p.booster.max_area / p.booster.opening_gain:.3f} N\n')
    report_identifiability(declared)
    if out is not None:
        path = out / 'identification.png'
        draw_identification(
            {'0 → 1.16 mA: Max': full, '0 → 0.4292 mA: k': small}, guess, p, path)
        print(f'\nPlot: {legible(path)}')


def identified_line(
    label: str, printed: float, guess: float, found: identification.Identified
) -> str:
    """Return a row of the table of identified parameters."""
    return (
        f'{label:26}{printed:12.3e}{guess:13.3e}{found.value:13.3e}'
        f'{found.value / printed - 1.0:+9.2%}{found.deviation / found.value:9.3%}')


def report_identifiability(p: PositionerParameters) -> None:
    """Print which combinations of area, volume, k and Max both steps determine."""
    known = identification.scaling_sensitivities(p)
    print('What both records determine of A, V0, k and Max (1 sigma, all four free):')
    for deviation, direction in zip(known.deviations, known.directions, strict=True):
        powers = ' '.join(
            f'{name}^{power:+.2f}' for name, power in zip(('A', 'V0', 'k', 'Max'), direction))
        print(f'  {powers}  ' + (f'{deviation:9.3%}' if deviation < 1.0 else ' not at all'))
    pressure, position = identification.largest_change(p, 0.44)
    print(
        'The last one is their common factor. Multiplying all four by 0.44 (mass and friction too)'
        f'\nmoves the pressure by {pressure:.1e} Pa and the position by {position:.1e} m at most: '
        'k and Max are\nidentified as ratios to the volume, given here by the assumed A and V0.')


if __name__ == '__main__':
    sys.exit(main())
