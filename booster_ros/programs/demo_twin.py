# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the demo in which a valve begins to rub, and its twin finds and adopts that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
import time

import numpy as np

from ..model.parameters import from_values
from ..model.stream import Stream
from ..parameters.file import read_parameter_file
from ..twin.alarm import Settings
from ..twin.answer_figure import Answer, draw_answer
from ..twin.diagnosing import Diagnosing
from ..twin.twin import Twin
from ..twin.verdict import FOUND, Verdict
from .demo_nodes import DemoError

ROW, PORTION = 0.05, 10
"""Time between two samples, s, and samples that the twin is given at once."""

CHANGE, LONGEST, AFTERWARDS = 330.0, 480.0, 30.0
"""When the packing begins to rub, when all is over at the latest, and what is shown after the end
of the trial, s."""

FAULT = {'actuator.coulomb_friction': 300.0, 'actuator.stiction': 100.0}
HYPOTHESES = ('stem_friction', 'position_backlash', 'chamber_leak', 'bench_set_shift')
"""Those of the launch file of the twin."""

NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
SETTINGS = Settings(block=1.0, learning=300.0)
HISTORY, TRIAL, LIMIT = 40.0, 20.0, 300.0

Samples = dict[str, np.ndarray]


def show_twin(out: Path) -> None:
    """Run valve and twin, print what the twin says, draw the picture and say where it is."""
    print(f'\nA twin learns a healthy valve for {SETTINGS.learning:.0f} s. Then the packing of the '
          'valve begins to rub.\nAll this without ROS, faster than real time; the diagnosis takes '
          'some twenty seconds.', flush=True)
    answer = answered(out / 'twin_reports')
    plot = out / 'twin.png'
    draw_answer(answer, NOISE['valve_position'], plot)
    print(f'\nPlot: {plot}\nReport: {answer.verdict.folder}/report.html')


def answered(reports: Path) -> Answer:
    """Return what the twin makes of a valve that begins to rub; DemoError if it says nothing."""
    twin = Twin(from_values({}), SETTINGS, history=HISTORY)
    diagnosing = Diagnosing(reports.absolute(), HYPOTHESES, LIMIT)
    said: dict[str, tuple[float, str]] = {}
    verdict: Verdict | None = None
    course: list[tuple[float, float]] = []

    def say(now: float, what: str, sentence: str) -> None:
        said[what] = now, sentence
        print(f'{now:5.0f} s  {what}: {sentence}', flush=True)

    try:
        for samples in _valve():
            now = float(samples['time'][-1])
            for alarm in _fed(twin, samples):
                if diagnosing.note(alarm, SETTINGS.block):
                    say(now, 'alarm', alarm.sentence)
            if 'valve_position' in twin.now:
                seen = twin.now['valve_position']
                course.append((seen.time, seen.read - seen.said))
            if verdict is None:
                verdict = _verdict(diagnosing, twin)
                if verdict is not None:
                    say(now, 'verdict', verdict.sentence)
                    _try_out(twin, verdict)
            if twin.trial is not None and twin.trial.is_over:
                outcome = twin.end_trial()
                say(now, 'adopted' if outcome.is_kept else 'rolled back', outcome.sentence)
            if twin.trial is None and verdict and now > said['verdict'][0] + TRIAL + AFTERWARDS:
                break
    finally:
        diagnosing.end()
    if verdict is None:
        raise DemoError('the twin came to no verdict on the valve that rubs')
    time_of, residual = np.array(course).T
    return Answer(time_of, residual, CHANGE, said, verdict)


def _try_out(twin: Twin, verdict: Verdict) -> None:
    if verdict.kind == FOUND:
        found = Path(verdict.folder) / 'positioner.yaml'
        twin.try_out(
            from_values(read_parameter_file(found).physical), TRIAL, verdict.uncertainty)


def _verdict(diagnosing: Diagnosing, twin: Twin) -> Verdict | None:
    """Let the diagnosis go on, to its end if it runs: no time passes for the valve meanwhile."""
    found = diagnosing.turn(time.monotonic(), twin.history, twin.parameters)
    while diagnosing.runs and found is None:
        time.sleep(0.1)
        found = diagnosing.turn(time.monotonic(), twin.history, twin.parameters)
    return found


def _fed(twin: Twin, samples: Mapping[str, np.ndarray]) -> list:
    for k, stamp in enumerate(samples['time'].tolist()):
        for name, values in samples.items():
            if name != 'time':
                twin.add(name, stamp, float(values[k]))
    return twin.update()


def _valve() -> Iterator[Samples]:
    """Yield what a valve publishes that is moved by three sines, in portions."""
    random = np.random.default_rng(0)
    state = {'chamber_pressure': 2e5}
    for begin, end, values in ((0.0, CHANGE, {}), (CHANGE, LONGEST, FAULT)):
        stream: Stream | None = None
        for start in np.arange(begin, end, PORTION * ROW):
            stamps = start + ROW * np.arange(PORTION)
            current = 0.433e-3 + 0.0027e-3 * sum(
                np.sin(2.0 * np.pi * frequency * stamps) for frequency in (0.21, 0.55, 0.83))
            stream = stream or Stream(from_values(values), stamps[0], current[0], state)
            seen = stream.advance(stamps, current)
            state = {name: float(seen[name][-1]) for name in NOISE}
            yield {'time': stamps, 'control_current': current, **{
                name: seen[name] + noise * random.standard_normal(PORTION)
                for name, noise in NOISE.items()}}
