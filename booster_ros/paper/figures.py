# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of Table I on the virtual bench, and of the two identification steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np

from ..model.booster import Booster
from ..model.simulation import simulate
from ..model.system import PositionerParameters
from ..writing.png import write_png
from .flow_bench import bench_flow, bench_force
from .identification import StepRecord
from .printed import FlowSeries


def draw_flow_bench(
    table: Sequence[FlowSeries], boosters: Mapping[str, Booster], path: Path
) -> None:
    """Draw printed and modelled flow over the diaphragm force, a panel for each supply."""
    figure = Figure(figsize=(11.0, 4.0), layout='constrained')
    panels = np.atleast_1d(figure.subplots(1, len(table), sharey=True))
    for panel, series in zip(panels, table, strict=True):
        force = bench_force(Booster(), series)
        panel.plot(force, series.mass_flow, 'o', markersize=4, color='black', label='Table I')
        sweep = _fine(series)
        for label, booster in boosters.items():
            panel.plot(bench_force(booster, sweep), bench_flow(booster, sweep), label=label)
        panel.set_title(f'supply {series.supply_pressure / 1e3:.0f} kPa')
        panel.set_xlabel('diaphragm force, N (gauge pressures)')
        panel.grid(alpha=0.3)
    panels[0].set_ylabel('mass flow, 1e-4 kg/s')
    panels[0].legend(frameon=False, fontsize=8)
    write_png(path, figure)


def _fine(series: FlowSeries) -> FlowSeries:
    """Return a fine sweep of the back pressure, from where the force is zero."""
    booster = Booster()
    first = series.supply_pressure * (booster.s2 - booster.s3) / booster.s1
    sweep = np.linspace(first, series.back_pressure[-1], 300)
    return series._replace(back_pressure=sweep, mass_flow=np.zeros_like(sweep))


def draw_identification(
    records: Mapping[str, StepRecord], guess: PositionerParameters, found: PositionerParameters,
    path: Path,
) -> None:
    """Draw the measured valve position with the model before and after, a panel for each step."""
    figure = Figure(figsize=(11.0, 4.0), layout='constrained')
    panels = np.atleast_1d(figure.subplots(1, len(records)))
    for panel, (title, record) in zip(panels, records.items(), strict=True):
        panel.plot(record.time, record.valve_position * 1e3, '.', markersize=2, color='0.6',
                   label='record')
        for label, p in (('first guess', guess), ('identified', found)):
            run = simulate(p, record.time, record.control_current)
            panel.plot(record.time, run['valve_position'] * 1e3, linewidth=1.2, label=label)
        panel.set_title(title)
        panel.set_xlabel('time, s')
        panel.set_ylabel('valve position, mm')
        panel.grid(alpha=0.3)
    panels[0].legend(frameon=False)
    write_png(path, figure)
