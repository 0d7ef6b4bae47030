# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The measured records of the project, and their diagnoses."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..diagnosis.pipeline import diagnose
from ..diagnosis.data.experiment import Experiment
from ..diagnosis.prepare.preparation import prepare
from ..diagnosis.result import Diagnosis
from ..model.parameters import from_values
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..paper.printed import FLOW_UNIT
from ..records import read_record
from ..report.engineering import Scale

ROOT = Path(__file__).resolve().parents[2]
"""The checkout; what is installed has no measurements."""

_STROKE = 38.1e-3
"""Stroke of the diaphragm actuator as its source states it, m."""

_TABLE_I = 'Table I of the paper (its authors; which instruments is not said)'
_ZILLEN = 'E. Zillen, MSc thesis, TU Delft 2021 (CC0-1.0)'


class MeasuredRecord(NamedTuple):
    """A file in measured/, the parameters that describe its device, and where it is from."""

    name: str
    parameters: str
    title: str
    what: str
    source: str
    unit: Scale
    """The unit in which its source, or a reader of it, counts errors."""

    @property
    def record_file(self) -> str:
        """The record, relative to the checkout."""
        return f'measured/{self.name}.csv'

    def experiment(self) -> tuple[Experiment, PositionerParameters, tuple[str, ...]]:
        """Return the experiment, the declared parameters, and notes on the reading."""
        declared = from_values(read_parameter_file(ROOT / self.parameters).physical)
        record = read_record(ROOT / self.record_file)
        experiment = prepare(record, declared)
        return experiment, declared, (*record.notes, *experiment.notes)

    def diagnosis(self) -> Diagnosis:
        """Return what `close_loop` says of it; RecordError, ParameterError as there."""
        experiment, declared, notes = self.experiment()
        return diagnose(experiment, declared, notes=notes)


def _chamber(material: str) -> MeasuredRecord:
    return MeasuredRecord(
        f'sealed_chamber_{material}', 'measured/sealed_chamber.yaml',
        f'Sealed chamber, {material}',
        'pressure over time in a chamber that was filled and shut off; its volume is not stated, '
        'so 1 litre is assumed and the leak area is per litre', _ZILLEN, Scale('kPa', 1e-3))


_FLOW = Scale('table units (1e-4 kg/s)', 1.0 / FLOW_UNIT)

FLOW_BENCH = MeasuredRecord(
    'booster_flow', 'config/positioner.yaml', 'Table I: flow of the booster',
    'flow against back pressure at three supply pressures, outlet open, 60 points, no time; the '
    'printed flow is read as 1e-4 kg/s', _TABLE_I, _FLOW)

FLOW_BENCH_WITHOUT_100 = MeasuredRecord(
    'booster_flow_150_200', 'config/positioner.yaml', 'Table I without its 100 kPa series',
    'the 40 points at 150 and 200 kPa; why the others are doubtful is said in '
    '[measured/README.md](../measured/README.md)', _TABLE_I, _FLOW)

SIGNATURE = MeasuredRecord(
    'diaphragm_actuator_signature', 'measured/diaphragm_actuator.yaml',
    'Signature of a diaphragm actuator',
    'air pressure and stem position, slowly up and down, 43 points, no time',
    'fig. 5 ("experimental") of M. Bartyś, *Specification of actuators intended to use for '
    'benchmark definition*, DAMADICS v1.02, 2002',
    Scale('% of the stated stroke, 38.1 mm', 100.0 / _STROKE))

CHAMBERS = tuple(_chamber(material) for material in ('aluminium', 'resin', 'filament'))

RECORDS = (FLOW_BENCH, FLOW_BENCH_WITHOUT_100, SIGNATURE, *CHAMBERS)
