# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the model's cost grows: with effects, with dry friction, with sets, with simulated time."""

from __future__ import annotations

from collections.abc import Callable
import os
import time
import tracemalloc

import numpy as np

from ..model.ensemble import simulate_ensemble
from ..model.parameters import from_values
from ..model.simulation import simulate
from ..model.stream import Stream
from . import cases
from .cases import Case

ROUNDS = 5

# each line adds to the ones before it
EFFECTS: tuple[tuple[str, dict[str, object]], ...] = (
    ('declared model', {}),
    ('chamber_leak', {'actuator.leak_area': 1e-8}),
    ('booster_dead_band', {'booster.intake_preload': 0.02, 'booster.exhaust_preload': 0.02}),
    ('tubing_restriction', {'tubing.restriction_area': 3e-6}),
    ('supply_droop', {'supply.droop': 1e7}),
    ('heat_transfer', {'actuator.thermal_resistance': 0.5}),
    ('stem_friction', {'actuator.coulomb_friction': 200.0, 'actuator.stiction': 60.0}),
)


def best_time(run: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Return the least time of some runs, s: what disturbs can only slow down."""
    best = np.inf
    for _ in range(ROUNDS):
        begin = clock()
        run()
        best = min(best, clock() - begin)
    return best


def case_speed(case: Case) -> float:
    """Return simulated seconds per CPU second."""
    length = case.time[-1] - case.time[0]
    return float(length / best_time(lambda: simulate(
        case.parameters, case.time, case.control_current, case.initial)))


def effects() -> str:
    """Return a table of the speed over the number of effects."""
    values: dict[str, object] = {}
    lines = ['| effects, added one by one | × real time |', '|---|---|']
    for name, more in EFFECTS:
        values |= more
        case = cases.paper_test()._replace(parameters=from_values(values))
        lines.append(f'| {name} | {case_speed(case):.0f} |')
    speed = case_speed(cases.stick_slip())
    lines.append(f'| a stick-slip record, stem_friction alone | {speed:.0f} |')
    return '\n'.join(lines)


def ensembles() -> str:
    """Return a table of the throughput of ensembles over threads."""
    case = cases.paper_test()
    length = case.time[-1] - case.time[0]

    def alone() -> object:
        return simulate(case.parameters, case.time, case.control_current)

    single, single_cpu = best_time(alone, time.perf_counter), best_time(alone)
    lines = ['| sets | threads | simulated s per s | per thread | CPU per set |',
             '|---|---|---|---|---|']
    cores = os.cpu_count() or 1
    for sets, threads in dict.fromkeys(((32, 1), (32, cores), (256, cores))):
        members = [
            from_values({'actuator.effective_area': 0.0796 * (1.0 + 1e-4 * k)})
            for k in range(sets)]

        def run(members: list = members, threads: int = threads) -> object:
            return simulate_ensemble(
                members, case.time, case.control_current, threads=threads)

        wall, cpu = best_time(run, time.perf_counter), best_time(run)
        lines.append(
            f'| {sets} | {threads} | {sets * length / wall:.0f} | '
            f'{100 * sets * single / wall / threads:.0f} % | '
            f'{100 * cpu / sets / single_cpu:.0f} % |')
    return '\n'.join(lines)


def durations() -> str:
    """Return a table of speed and memory over simulated time, 100 Hz in portions of 10 minutes."""
    lines = ['| simulated | × real time | largest memory, MB |', '|---|---|---|']
    portion = 60_000
    for hours in (1, 6, 24):
        tracemalloc.start()
        begin = time.process_time()
        stream = Stream(from_values({}), 0.0, 0.4e-3)
        for first in range(0, hours * 360_000, portion):
            t = (first + np.arange(portion)) * 0.01
            stream.advance(t, 0.41e-3 + 0.03e-3 * np.sin(0.3 * t))
        used = time.process_time() - begin
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        lines.append(f'| {hours} h | {hours * 3600 / used:.0f} | {peak / 1e6:.0f} |')
    return '\n'.join(lines)


def document() -> str:
    """Return the sections on scaling."""
    return f"""## Effects

{effects()}

## Ensembles

Throughput per thread (wall time) and CPU time per set, both relative to a single run alone. What
else runs on the machine lowers the former. The results are those of single runs to the last bit
whatever the number of threads.

{ensembles()}

## Simulated time

{durations()}
"""
