# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`report.json`: the diagnosis for programs, SI units, null where a number does not exist."""

from collections.abc import Mapping
from dataclasses import asdict
import json
import math
from typing import Any

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.diagnosis.result import (
    ChannelError, Diagnosis, FalseAdd, FoundEffect)
from booster_ros.report.notes import notes
from booster_ros.report.provenance import Provenance
from booster_ros.report.unknown_term import UnknownTerm, unknown_experiment, unknown_of
from booster_ros.report.wording import SCALING, verdict_sentences, verdict_title


VERSION = 3
"""Of the report's keys: 2 has `trace`, and `standing` and `explained` of each effect, 3 has no
`mostly` and no `moved`."""


def json_text(diagnosis: Diagnosis, provenance: Provenance) -> str:
    """Return the report as JSON text."""
    values = _finite(report_values(diagnosis, provenance))
    return json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + '\n'


def report_values(diagnosis: Diagnosis, provenance: Provenance) -> dict[str, Any]:
    """Return the report as plain values."""
    return {
        'version': VERSION,
        'verdict': diagnosis.verdict,
        'summary': ' '.join([f'{verdict_title(diagnosis)}.', *verdict_sentences(diagnosis)]),
        'effects': [_effect(effect, unknown_of(diagnosis)) for effect in diagnosis.effects],
        'unknown': _unknown(unknown_of(diagnosis)),
        'refused': diagnosis.refused and asdict(diagnosis.refused),
        'change': diagnosis.change and asdict(diagnosis.change),
        'error': _errors(diagnosis.error),
        'held_out': _errors(diagnosis.held_out),
        'validation': _errors(diagnosis.validation),
        'false_add': _false_add(diagnosis.false_add),
        'suspects': [
            {'effects': list(s.effects), 'misfit': s.misfit, 'reason': s.reason}
            for s in diagnosis.suspects],
        'trace': [
            {'effects': list(step.effects), 'against': list(step.against),
             'reduced_chi2': step.reduced_chi2, **step.found.figures(), 'outcome': step.outcome}
            for step in diagnosis.trace],
        'declared_parameters': {
            r.name: {'given': r.given, 'before': r.before, 'after': r.after, 'spread': r.spread,
                     'low': r.low, 'high': r.high, 'unit': r.unit, 'at_limit': r.at_limit}
            for r in diagnosis.refitted},
        'identifiability': SCALING,
        'record': _record(diagnosis.experiment, provenance),
        'segments': [
            {'from': float(diagnosis.experiment.time[s.first]),
             'to': float(diagnosis.experiment.time[s.last - 1]), 'role': s.role}
            for s in diagnosis.segments],
        'notes': list(notes(diagnosis)),
    }


def _effect(effect: FoundEffect, unknown: UnknownTerm | None) -> dict[str, Any]:
    experiment = unknown_experiment(unknown) if unknown else effect.separating_experiment
    return {
        'name': effect.name,
        'location': effect.location,
        'parameters': {
            name: {'value': i.value, 'low': i.low, 'high': i.high, 'unit': i.unit,
                   'open_above': i.open_above}
            for name, i in effect.parameters.items()},
        'confused_with': list(effect.confused_with),
        'separating_experiment': experiment,
        'standing': effect.standing,
        'explained': effect.explained,
        'evidence': dict(effect.evidence),
    }


def _unknown(term: UnknownTerm | None) -> dict[str, Any] | None:
    if term is None:
        return None
    return {
        'location': term.location, 'unit': term.unit,
        'variable': term.variable, 'variable_unit': term.variable_unit, 'memory': term.memory,
        'reach': term.reach,
        'at': [float(v) for v in term.knots], 'values': [float(v) for v in term.values],
    }


def _errors(errors: Mapping[str, ChannelError]) -> dict[str, Any]:
    return {
        name: {'unit': e.unit, 'declared': e.declared, 'before': e.before, 'after': e.after,
               'noise': e.noise, 'left_open': e.left_open, 'unforeseen': e.unforeseen}
        for name, e in errors.items()}


def _false_add(found: FalseAdd | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        'runs': found.runs, 'gained': found.gained, 'rate': found.rate,
        'interval': [found.low, found.high], 'names': dict(found.names),
    }


def _record(experiment: Experiment, provenance: Provenance) -> dict[str, Any]:
    return {
        'file': provenance.record,
        'parameter_file': provenance.parameters,
        'validation_file': provenance.validation or None,
        'rows': len(experiment.time),
        'begins': experiment.begins,
        'quasi_static': experiment.quasi_static,
        'driven_by': list(experiment.drives),
        'compared': list(experiment.channels),
    }


def _finite(value: Any) -> Any:
    """Return the same values with None for the numbers that JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _finite(content) for key, content in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(content) for content in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
