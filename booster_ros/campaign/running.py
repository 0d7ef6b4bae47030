# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running the cases of a campaign, a process each, and keeping what comes of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
import json
from pathlib import Path
import shutil
import threading
from typing import Any

import numpy as np

from ..running.on_dask import run_orders
from ..running.program import Program
from .cases import NOISE, Case, Truth
from .scoring import ANSWERED, FAILED, TIMEOUT, Outcome, answer_of

KEPT = ('report.json', 'positioner.yaml', 'positioner_before.yaml')
"""Files of a diagnosis that stay in the folder of a campaign; pages are too large for that."""

SIMULATION_SECONDS = 300.0
"""How long one simulation of the second record may take."""


def run_cases(
    cases: Sequence[Case], program: Program, out: Path, timeout: float, scheduler: str, jobs: int,
    tell: Callable[[Outcome], None], check: Callable[[], None],
) -> None:
    """
    Run cases as `run_orders` says; one whose worker failed has an outcome as well.

    `out` is the folder of the campaign; what takes more than `timeout` seconds has no answer.
    """
    by_name = {f'{case.set}/{case.name}': case for case in cases}

    def fail(name: str, why: str) -> None:
        case = by_name[name]
        tell(Outcome(case.set, case.name, case.digest(), program.state(), FAILED, why, 0.0, 0.0,
                     case.truth))

    run_orders('booster_ros.campaign.running:judged',
               {name: {'case': asdict(case), 'program': asdict(program), 'out': out,
                       'timeout': timeout} for name, case in by_name.items()},
               scheduler, jobs, tell, fail, check)


def judged(values: Mapping[str, Any], stop: threading.Event) -> Outcome | None:
    """Run the case of an order of `run_cases`."""
    case = Case(**{**values['case'], 'truth': Truth(**values['case']['truth'])})
    return run_case(case, stop, Program(**values['program']), values['out'], values['timeout'])


def run_case(case: Case, stop: threading.Event, program: Program, out: Path, timeout: float
             ) -> Outcome | None:
    """
    Run `close_loop` on a case and the models that it writes over the second record.

    `out` is the folder of the campaign. A run that fails or takes more than `timeout` seconds is
    an outcome too; None is returned where `stop` ended it.
    """
    kept = out / 'reports' / case.set / case.name
    shutil.rmtree(kept, ignore_errors=True)
    kept.mkdir(parents=True)
    try:
        outcome = _answered(case, stop, program, kept, timeout)
    finally:
        _tidy(kept)
    return None if stop.is_set() else outcome


def _answered(case: Case, stop: threading.Event, program: Program, kept: Path, timeout: float
              ) -> Outcome:
    state = program.state()
    ended = program.run(
        'close_loop', ['--record', case.record, '--params', case.declared, '--out', kept],
        timeout, stop)

    def outcome(status: str, message: str, **answer: Any) -> Outcome:
        return Outcome(case.set, case.name, case.digest(), state, status, message, ended.seconds,
                       ended.cpu_seconds, case.truth, **answer)

    if ended.status is None:
        return outcome(TIMEOUT, f'no answer in {timeout:g} s')
    if ended.status:
        return outcome(FAILED, ended.said or f'close_loop ended with {ended.status}')
    try:
        report = json.loads((kept / 'report.json').read_text(encoding='utf-8'))
        answer = answer_of(report, case.truth.parameters)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        return outcome(FAILED, f'report.json cannot be read: {error!r}')
    before, note = _missed(program, kept, 'positioner_before', case.other, stop)
    after, other_note = _missed(program, kept, 'positioner', case.other, stop)
    return outcome(ANSWERED, note or other_note, before=before, after=after, **answer)


def _missed(program: Program, folder: Path, name: str, record: Path, stop: threading.Event
            ) -> tuple[dict[str, float] | None, str]:
    """Return the errors of a model on a record by channel, or None and why there are none."""
    if not record.exists():
        return None, f'there is no {record.name}'
    simulated = folder / f'{name}.csv'
    ended = program.run(
        'simulate', ['--params', folder / f'{name}.yaml', '--input', record, '--out', simulated],
        SIMULATION_SECONDS, stop)
    if ended.status != 0:
        return None, ended.said or 'simulate took too long'
    try:
        return errors_between(*(np.genfromtxt(path, delimiter=',', names=True)
                                for path in (simulated, record))), ''
    except (OSError, ValueError) as error:
        return None, f'{record.name}: {error}'


def _tidy(folder: Path) -> None:
    """Remove what is not kept, also what a run left that was ended."""
    for path in folder.iterdir():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        elif path.name not in KEPT:
            path.unlink()


def errors_between(simulated: Any, measured: Any) -> dict[str, float]:
    """Return the RMS difference of each channel that two tables have, row by row."""
    rows = min(len(simulated), len(measured))
    both = set(simulated.dtype.names) & set(measured.dtype.names)
    return {channel: float(np.sqrt(np.nanmean(
                (simulated[channel][:rows] - measured[channel][:rows])**2)))
            for channel in NOISE if channel in both}


def is_done(outcome: Outcome, digest: str, state: str, timeout: float) -> bool:
    """
    Tell whether a case of this digest need not be run again with a program of this state.

    What failed is: it may have been the machine.
    """
    if (outcome.inputs, outcome.state) != (digest, state):
        return False
    return outcome.answered or (outcome.status == TIMEOUT and outcome.seconds >= timeout)
