# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`positioner.yaml` and `positioner_before.yaml`: the models of a diagnosis, ready for the node."""

from collections.abc import Mapping
from pathlib import Path
import textwrap
from typing import Any

from booster_ros.diagnosis.estimation.uncertainty import Interval
from booster_ros.diagnosis.result import Diagnosis
from booster_ros.model.discrepancy import Discrepancy
from booster_ros.parameters.file import write_parameter_file
from booster_ros.report.engineering import number
from booster_ros.report.provenance import Provenance
from booster_ros.report.wording import SCALING, verdict_sentences, verdict_title


def write_parameter_files(
    folder: Path, diagnosis: Diagnosis, provenance: Provenance, node: Mapping[str, Any]
) -> None:
    """
    Write the model with what it lacked, and the declared model refitted without it.

    Both have the node's own parameters, `node`, as declared.
    """
    origin = f'Declared in {provenance.parameters}, fitted to {provenance.record}.'
    verdict = ' '.join([f'{verdict_title(diagnosis)}.', *verdict_sentences(diagnosis)])
    write_parameter_file(
        folder / 'positioner.yaml', diagnosis.after, _heading(verdict, origin, SCALING),
        _fitted(diagnosis, 'after') | _added(diagnosis), node)
    write_parameter_file(
        folder / 'positioner_before.yaml', diagnosis.before,
        _heading('The declared model, refitted within its tolerances, nothing added.', origin,
                 SCALING),
        _fitted(diagnosis, 'before'), node)


def _heading(*paragraphs: str) -> str:
    return '\n'.join(line for text in paragraphs for line in textwrap.wrap(text, 97))


def _fitted(diagnosis: Diagnosis, stage: str) -> dict[str, str]:
    """Return a comment for each declared parameter that the fit has moved."""
    comments: dict[str, list[str]] = {}
    for row in diagnosis.refitted:
        if getattr(row, stage) != row.given:
            name = row.name.split('[')[0]
            comments.setdefault(name, []).append(number(row.given, 6))
    return {name: f'fitted, declared {" and ".join(given)}' for name, given in comments.items()}


def _added(diagnosis: Diagnosis) -> dict[str, str]:
    """Return a comment for each parameter that was added."""
    comments = {
        name: f'ADDED: {effect.name}, {_in_words(i)}'
        for effect in diagnosis.effects for name, i in effect.parameters.items()}
    if diagnosis.unknown is not None:
        comments |= {f'discrepancy.{field}': 'ADDED: no named effect explains this'
                     for field in Discrepancy._fields}
    return comments


def _in_words(interval: Interval) -> str:
    if interval.open_above:
        return f'95 % from {number(interval.low)} up, or none, which is 0'
    return f'95 % between {number(interval.low)} and {number(interval.high)}'
