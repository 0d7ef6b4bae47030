# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the model's cost grows: with effects, with dry friction, with sets, with simulated time."""

from __future__ import annotations

import os
import statistics
import time

import numpy as np

from ..model.ensemble import simulate_ensemble
from ..model.parameters import from_values
from ..model.simulation import simulate
from . import cases, long_records
from .cases import Case

ROUNDS = 5
ENSEMBLE_ROUNDS = 15
FRICTION_ROUNDS = 15

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


def case_speed(case: Case) -> float:
    """Return simulated seconds per CPU second, of the best run: disturbances only slow down."""
    return float(case.time[-1] - case.time[0]) / min(_cpu_time(case) for _ in range(ROUNDS))


def _cpu_time(case: Case) -> float:
    begin = time.process_time()
    simulate(case.parameters, case.time, case.control_current, case.initial)
    return time.process_time() - begin


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
    lines = ['| sets | threads | simulated s per s | per thread | CPU per set |',
             '|---|---|---|---|---|']
    cores = os.cpu_count() or 1
    length = cases.paper_test().time[-1]
    for sets, threads in dict.fromkeys(((32, 1), (32, cores), (256, cores))):
        rounds = [_ensemble_and_alone(sets, threads) for _ in range(ENSEMBLE_ROUNDS)]
        wall, share, cpu = (statistics.median(column) for column in zip(*rounds, strict=True))
        lines.append(f'| {sets} | {threads} | {sets * length / wall:.0f} | '
                     f'{100 * share / threads:.0f} % | {100 * cpu:.0f} % |')
    return '\n'.join(lines)


def _ensemble_and_alone(sets: int, threads: int) -> tuple[float, float, float]:
    """
    Return wall time (s) of an ensemble, and its throughput and CPU time beside single runs.

    The single runs are as many, one after the other, half of them before and half after it: what
    else the machine does disturbs both alike.
    """
    case = cases.paper_test()
    members = [from_values({'actuator.effective_area': 0.0796 * (1.0 + 1e-4 * k)})
               for k in range(sets)]

    def alone() -> None:
        for member in members[::2]:
            simulate(member, case.time, case.control_current)

    def clocks() -> tuple[float, float]:
        return time.perf_counter(), time.process_time()

    begin = clocks()
    alone()
    before = clocks()
    simulate_ensemble(members, case.time, case.control_current, threads=threads)
    after = clocks()
    alone()
    end = clocks()
    wall, cpu = (after[k] - before[k] for k in (0, 1))
    wall_alone, cpu_alone = (end[k] - begin[k] - (after[k] - before[k]) for k in (0, 1))
    return wall, wall_alone / wall, cpu / cpu_alone


FRICTION: tuple[tuple[str, dict[str, object]], ...] = (
    ('none', {'actuator.coulomb_friction': 0.0, 'actuator.stiction': 0.0}),
    ('sliding friction 400 N', {'actuator.coulomb_friction': 400.0, 'actuator.stiction': 0.0}),
    ('300 N, and 100 N more to break away', {
        'actuator.coulomb_friction': 300.0, 'actuator.stiction': 100.0}),
    ('the same with presliding', {
        'actuator.coulomb_friction': 300.0, 'actuator.stiction': 100.0,
        'actuator.presliding_stiffness': 3e6}),
    ('400 N, and 300 N more to break away', {
        'actuator.coulomb_friction': 400.0, 'actuator.stiction': 300.0}),
)


def slips(case: Case) -> int:
    """Return how often the stem starts from a standstill."""
    seen = simulate(case.parameters, case.time, case.control_current, case.initial)
    moving = np.abs(np.diff(seen['valve_position'])) > 1e-9
    return int(np.sum(moving[1:] & ~moving[:-1]))


def friction() -> str:
    """Return a table of what dry friction costs on the same input, medians of interleaved runs."""
    lines = ['| run | dry friction | starts from rest | × real time | time, relative to none |',
             '|---|---|---|---|---|']
    for case in (cases.paper_test(), cases.moving_command(), cases.stick_slip()):
        runs = [case._replace(parameters=from_values(values)) for _, values in FRICTION]
        rounds = [[_cpu_time(one) for one in runs] for _ in range(FRICTION_ROUNDS)]
        for k, (name, _) in enumerate(FRICTION):
            needed = statistics.median(times[k] for times in rounds)
            ratio = statistics.median(times[k] / times[0] for times in rounds)
            lines.append(f'| {case.name} | {name} | {slips(runs[k])} | '
                         f'{case.time[-1] / needed:.0f} | {ratio:.2f} |')
    return '\n'.join(lines)


def document() -> str:
    """Return the sections on scaling."""
    return f"""## Effects

Each time is the best of {ROUNDS} runs, so speeds are higher than the medians elsewhere.

{effects()}

## Dry friction

The same rows without and with it, medians of {FRICTION_ROUNDS} rounds. Beside a current that
stands, a stem without friction is carried on over many rows in a step, and every slip ends such a
step. With presliding the stem rests on a spring and has no moments at which it starts.

{friction()}

## Ensembles

Throughput per thread (wall time) and CPU time per set, both relative to the same sets run one by
one, half of them before and half after; medians of {ENSEMBLE_ROUNDS} rounds. Throughput per
thread also falls where something else runs on the machine or threads share a core; CPU time per set
shows what the ensemble itself costs. The results are those of single runs to the last bit whatever
the number of threads.

{ensembles()}

{long_records.document()}"""
