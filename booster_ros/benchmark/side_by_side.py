# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Speed beside what users would pick instead, on one input, at the accuracy that each reaches.

    python -m booster_ros.benchmark.side_by_side

Writes the tables of docs/benchmarks.md and the work-precision plot. CPU time of one thread, runs
of all peers interleaved, medians: what else the machine does disturbs them alike.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import sys
import time
from typing import NamedTuple

import matplotlib
import numpy as np
from tqdm import tqdm

from ..model.simulation import simulate
from ..model.state import POSITION, STATE_NAMES
from . import cases, peers, scaling
from .cases import Case
from .reference import scipy_integrator

OURS = 'booster_ros, compiled'
ROUNDS = 3
DOCS = Path(__file__).resolve().parents[2] / 'docs'
WANTED = 5e-6
"""Position error, m RMS, at which the peers are compared."""

RTOLS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
STEPS = (1e-4, 5e-5, 2.5e-5)
TOLERANCES = (30.0, 10.0, 3.0, 1.0, 0.3, 0.1)


class Contestant(NamedTuple):
    """A way to run a case, and the accuracies (tolerance or step) to try."""

    name: str
    run: Callable[[Case, float], np.ndarray]
    settings: tuple[float, ...]


class Result(NamedTuple):
    """RMS position error, m; median, least and largest of simulated seconds per CPU second."""

    name: str
    setting: float
    error: float
    speed: float
    slowest: float
    fastest: float


def ours(compiled: bool) -> Callable[[Case, float], np.ndarray]:
    """Return a run of our solver at a multiple of its tolerance."""
    def run(case: Case, tolerance: float) -> np.ndarray:
        outcome = simulate(
            case.parameters, case.time, case.control_current, case.initial,
            tolerance=tolerance, compiled=compiled)
        return np.stack([outcome[STATE_NAMES[s]] for s in peers.MOVING], axis=1)
    return run


def stick_slip_contestants() -> list[Contestant]:
    """Return what can follow a stem that sticks."""
    return [
        Contestant(OURS, ours(True), TOLERANCES),
        Contestant('booster_ros, plain Python', ours(False), (1.0,)),
        Contestant('LSODA (scipy), numba rates', peers.stick_slip_peer(
            scipy_integrator('LSODA')), RTOLS[::2]),
        Contestant('CVODE (SUNDIALS), numba rates', peers.stick_slip_peer(
            peers.cvode_integrator()), RTOLS[::2]),
    ]


def contestants() -> list[Contestant]:
    """Return all that are compared where nothing sticks."""
    machine = peers.machine_rates()
    return [
        Contestant(OURS, ours(True), TOLERANCES),
        Contestant('booster_ros, plain Python', ours(False), (1.0,)),
        Contestant('LSODA (scipy), Python rates', peers.scipy_peer(
            'LSODA', peers.python_rates()), (1e-6,)),
        Contestant('LSODA (scipy), numba rates', peers.scipy_peer('LSODA', machine), RTOLS),
        Contestant('CVODE (SUNDIALS), numba rates', peers.cvode_peer(machine), RTOLS),
        Contestant('LSODA, numba rates, no restarts', peers.scipy_peer(
            'LSODA', machine, restart=False), RTOLS),
        Contestant('CVODE, numba rates, no restarts', peers.cvode_peer(
            machine, restart=False), RTOLS),
        Contestant('Runge-Kutta 4, all numba', peers.runge_kutta_peer(machine), STEPS),
    ]


def measure(case: Case, exact: np.ndarray, compared: list[Contestant]) -> list[Result]:
    """Return every contestant's error and speed at every setting, runs interleaved."""
    entries = [(c, setting) for c in compared for setting in c.settings]
    speeds: list[list[float]] = [[] for _ in entries]
    errors = [0.0] * len(entries)
    length = case.time[-1] - case.time[0]
    position = peers.MOVING.tolist().index(POSITION)
    for contestant, setting in tqdm(entries, 'compiling, first runs', file=sys.stderr):
        found = contestant.run(case, setting)[:, position]
        errors[entries.index((contestant, setting))] = float(
            np.sqrt(np.mean((found - exact) ** 2)))
    for _ in tqdm(range(ROUNDS), 'rounds', file=sys.stderr):
        for k, (contestant, setting) in enumerate(entries):
            begin = time.process_time()
            contestant.run(case, setting)
            speeds[k].append(length / (time.process_time() - begin))
    return [
        Result(c.name, setting, error, float(np.median(s)), min(s), max(s))
        for (c, setting), error, s in zip(entries, errors, speeds, strict=True)
    ]


def exact_position(run: Callable[[Case, float], np.ndarray], case: Case) -> np.ndarray:
    """Return the positions that a peer gives at a relative tolerance of 1e-10."""
    return run(case, 1e-10)[:, peers.MOVING.tolist().index(POSITION)]


def best_within(results: list[Result], error: float) -> list[Result]:
    """Return each contestant's fastest result among those at most this inexact."""
    best: dict[str, Result] = {}
    for result in results:
        if result.error <= error and (
                result.name not in best or result.speed > best[result.name].speed):
            best[result.name] = result
    return list(best.values())


def table(results: list[Result]) -> str:
    """Return a Markdown table."""
    lines = ['| solver | setting | position RMS, µm | × real time | least – most |',
             '|---|---|---|---|---|']
    lines += [
        f'| {r.name} | {r.setting:g} | {1e6 * r.error:.3g} | {r.speed:.0f} | '
        f'{r.slowest:.0f} – {r.fastest:.0f} |' for r in results]
    return '\n'.join(lines)


def plot(outcomes: dict[str, list[Result]], path: Path) -> None:
    """Draw work over precision, a panel for each case."""
    matplotlib.use('Agg')
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(
        1, len(outcomes), figsize=(14.0, 4.5), layout='constrained', sharey=True)
    names = list(dict.fromkeys(r.name for results in outcomes.values() for r in results))
    for axes, (case, results) in zip(panels, outcomes.items(), strict=True):
        for name in dict.fromkeys(r.name for r in results):
            mine = [r for r in results if r.name == name]
            # within a nanometre the last digits of the reference count
            axes.loglog([max(1e6 * r.error, 1e-3) for r in mine], [r.speed for r in mine],
                        'o-', label=name, color=f'C{names.index(name)}')
        axes.axvline(1e6 * WANTED, color='grey', linestyle=':', label='5 µm')
        axes.set(title=case, xlabel='position error, µm RMS')
        axes.grid(which='both', alpha=0.3)
    panels[0].set_ylabel('simulated seconds per CPU second')
    panels[0].legend(fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    pyplot.close(figure)


def ratios(results: list[Result]) -> str:
    """
    Return how many times faster ours is at its default tolerance than each peer as exact as it.

    Errors below a nanometre count as one.
    """
    (mine,) = (r for r in results if r.name == OURS and r.setting == 1.0)
    lines = ['| peer, as exact as ours by default | ours is faster by | within 5 µm, by |',
             '|---|---|---|']
    equal = {r.name: r.speed for r in best_within(results, max(mine.error, 1e-9))}
    loose = {r.name: r.speed for r in best_within(results, WANTED)}
    for name, speed in loose.items():
        if 'booster_ros' not in name:
            exact = f'{mine.speed / equal[name]:.1f} ×' if name in equal else 'not reached'
            lines.append(f'| {name} | {exact} | {loose[OURS] / speed:.1f} × |')
    return '\n'.join(lines)


def section(case: Case, results: list[Result]) -> str:
    """Return the text on one case."""
    return f"""## {case.name.capitalize()}

{case.time[-1]:g} s, rows of {1e3 * cases.ROW:g} ms.

{ratios(results)}

{table(results)}
"""


def document(sections: list[str]) -> str:
    """Return the text of docs/benchmarks.md."""
    text = '\n'.join(sections)
    return f"""# Speed, side by side

Written by `make bench`: medians of {ROUNDS} interleaved runs on one thread, CPU time, on whatever
machine it ran last. All solve the same equations, starting anew where the current changes, but
for two that find their way through the changes by step control alone. The error is against Radau
at a relative tolerance of 1e-10. A setting is a relative tolerance, a step
in s, or a multiple of our solver's tolerance. *As exact as ours* takes each peer at its fastest
setting whose error is no more than ours; *within 5 µm* takes everybody, ours too, at the fastest
setting with an error below 5 µm, which is less than the 8 µm of noise that a position sensor has.

- *paper test*: the current changes three times in 46 s. Kind to solvers that choose their own
  steps and interpolate at the rows; so does ours where the current stands.
- *moving command*: the current changes at every row, as in a closed loop or a recorded sweep.
- *stick-slip*: the current changes at every row, the stem sticks and slips. The peers find these
  moments by their own search for events, and start anew in the equations that hold from there.

![work and precision](figures/work_precision.svg)

{text}
What the peers are spared and ours is not: outputs besides the states, sensors. JAX (diffrax) is not
among them: it cannot take functions that branch on values, and would solve a second copy of the
equations.

{scaling.document()}"""


def main() -> int:
    """Measure and write the documents."""
    outcomes, sections = {}, []
    smooth = peers.scipy_peer('Radau', peers.machine_rates()), contestants
    sticking = peers.stick_slip_peer(scipy_integrator('Radau')), stick_slip_contestants
    for case, (radau, compared) in (
        (cases.paper_test(), smooth), (cases.moving_command(), smooth),
        (cases.stick_slip(), sticking),
    ):
        outcomes[case.name] = measure(case, exact_position(radau, case), compared())
        sections.append(section(case, outcomes[case.name]))
    plot(outcomes, DOCS / 'figures' / 'work_precision.svg')
    text = document(sections)
    (DOCS / 'benchmarks.md').write_text(text, encoding='utf-8')
    print(text)
    return 0


if __name__ == '__main__':
    sys.exit(main())
