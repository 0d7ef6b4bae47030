# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A plant of valves through `fleet`: on workers of its own, and on a scheduler with two in processes.

    python -m booster_ros.benchmark.fleet_scaling FOLDER [VALVES [WORKERS ...]]

WORKERS of its own are 1 and 2 unless given. FOLDER gets the plant and a folder for each way.
Records are short, and the effects that are tried are few, so that a valve takes seconds: what is
measured is the fleet, not the diagnosis. Prints what each way took, and whether all came to the
same.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import json
from pathlib import Path
import subprocess
import sys
import time

import numpy as np

from ..model.parameters import from_values
from ..model.simulation import simulate
from ..records import CsvWriter

VALVES = 200
ROWS, ROW = 2000, 0.02
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
TRIED = ('chamber_leak', 'stem_friction')
KINDS = {
    'sound': {}, 'leaks': {'actuator.leak_area': 6e-8},
    'sticks': {'actuator.coulomb_friction': 500.0, 'actuator.stiction': 150.0}, 'also sound': {}}


def make_plant(folder: Path, count: int) -> Path:
    """Write records of so many valves, all of them different, and the manifest."""
    folder.mkdir(parents=True)
    (folder / 'declared.yaml').write_text('/**:\n  ros__parameters: {}\n', encoding='utf-8')
    lines = ['valve,record,parameters']
    for number in range(count):
        kind = list(KINDS)[number % len(KINDS)]
        rng = np.random.default_rng(number)
        t = ROW * np.arange(ROWS)
        # from one level to the next in a second, at times that are the valve's own
        levels = rng.uniform(0.40e-3, 0.46e-3, 10)
        current = np.interp(t % 4.0, (0.0, 1.0, 4.0), (0.0, 1.0, 1.0))
        place = (t // 4.0).astype(int)
        current = levels[np.maximum(place - 1, 0)] * (1.0 - current) + levels[place] * current
        run = simulate(from_values(KINDS[kind]), t, current)
        name = f'FV-{number + 1:03}'
        with CsvWriter(folder / f'{name}.csv', ('time', 'control_current', *NOISE)) as writer:
            writer.write_rows(np.column_stack([t, current, *(
                run[channel] + noise * rng.standard_normal(ROWS)
                for channel, noise in NOISE.items())]))
        lines.append(f'{name},{name}.csv,declared.yaml')
    manifest = folder / 'plant.csv'
    manifest.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return manifest


@contextmanager
def scheduler(folder: Path, workers: int) -> Iterator[str]:
    """Yield the address of a scheduler with workers, each a process of its own."""
    file = folder / 'scheduler.json'
    file.unlink(missing_ok=True)
    module = 'distributed.cli.dask_'
    started = [subprocess.Popen(
        [sys.executable, '-m', f'{module}scheduler', '--host', '127.0.0.1', '--port', '0',
         '--no-dashboard', '--scheduler-file', str(file)], stderr=subprocess.DEVNULL)]
    try:
        while not file.exists():
            time.sleep(0.1)
        started += [subprocess.Popen(
            [sys.executable, '-m', f'{module}worker', '--scheduler-file', str(file), '--nthreads',
             '1', '--no-nanny', '--no-dashboard'], stderr=subprocess.DEVNULL)
            for _ in range(workers)]
        yield str(json.loads(file.read_text(encoding='utf-8'))['address'])
    finally:
        for process in started[::-1]:
            process.terminate()
            process.wait()


def timed(manifest: Path, out: Path, *options: str) -> float:
    """Return how long the fleet took, s."""
    begin = time.perf_counter()
    subprocess.run([sys.executable, '-m', 'booster_ros', 'fleet', str(manifest), '--out', str(out),
                    *options, '--only', *TRIED], check=True)
    return time.perf_counter() - begin


def reports_of(out: Path) -> dict[str, bytes]:
    """Return the reports of a fleet by valve."""
    return {path.parent.name: path.read_bytes() for path in out.glob('valves/*/report.json')}


def main() -> int:
    """Run the fleets and print what they took."""
    folder = Path(sys.argv[1])
    manifest = make_plant(folder, int(sys.argv[2]) if len(sys.argv) > 2 else VALVES)
    took = {}
    ways = sys.argv[3:] or ['1', '2']
    for jobs in ways:
        took[f'{jobs} of its own'] = timed(manifest, folder / f'local_{jobs}', '--jobs', jobs)
    with scheduler(folder, 2) as address:
        took['2 of a scheduler'] = timed(manifest, folder / 'scheduler', '--scheduler', address)
    first, *others = (
        reports_of(folder / name) for name in (*(f'local_{jobs}' for jobs in ways), 'scheduler'))
    print('| workers | s | s a valve |\n|---|---|---|')
    for name, seconds in took.items():
        print(f'| {name} | {seconds:.0f} | {seconds / len(first):.2f} |')
    print(f'{len(first)} reports; the same to the last byte: {all(first == one for one in others)}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
