# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a twin has to know again after a restart, in one file.

One file, replaced as a whole: a model and what is healthy for it never come from two times. A
check sum tells a damaged file from a whole one.
"""

from collections.abc import Mapping
import hashlib
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

from ..model.parameters import ParameterError, from_values, to_values
from ..model.system import PositionerParameters
from ..writing.replacement import write_file
from .verdict import Verdict

VERSION = 2
"""Rises with each change of what a file holds."""

ASIDE = '.aside'
"""What is appended to the name of a file that cannot be used, so that nothing is lost."""


class RecallError(ValueError):
    """A file that cannot be used; the message is one sentence that names it."""


class OnTrial(NamedTuple):
    """A positioner that was given a model on trial, and what its parameters were before."""

    positioner: str
    before: dict[str, Any]


class Memory(NamedTuple):
    """All of it; None where there is nothing."""

    model: PositionerParameters | None = None
    """The adopted model."""
    calibration: dict[str, Any] | None = None
    """How the valve is while it is healthy, as `Twin.calibration` has it."""
    verdict: Verdict | None = None
    on_trial: OnTrial | None = None


def digest_of(parameters: PositionerParameters) -> str:
    """Return a text that is another one for any other model."""
    return _digest(json.dumps(to_values(parameters), sort_keys=True))


def save(path: Path, declared: PositionerParameters, memory: Memory) -> None:
    """Replace the file, whole or not at all; OSError. `declared` is the model that was given."""
    model = None if memory.model is None else to_values(memory.model)
    content = json.dumps({
        'declared': digest_of(declared), 'model': model, 'calibration': memory.calibration,
        'verdict': memory.verdict and memory.verdict._asdict(),
        'on_trial': memory.on_trial and list(memory.on_trial)})
    text = json.dumps({'version': VERSION, 'digest': _digest(content), 'content': content})
    write_file(Path(os.path.realpath(path)), text.encode())


def recall(path: Path, declared: PositionerParameters) -> Memory:
    """
    Return what was saved, nothing where there is no file.

    Raises:
        RecallError: it is damaged, or of another model or version.
        OSError: it cannot be read.

    """
    try:
        text = path.read_text(encoding='utf-8')
    except FileNotFoundError:
        return Memory()
    except UnicodeDecodeError:
        raise RecallError(f'{path} is damaged: it is no text') from None
    try:
        outer = json.loads(text)
        if outer['version'] != VERSION:
            raise RecallError(f'{path} is of another version of this package')
        if outer['digest'] != _digest(outer['content']):
            raise RecallError(f'{path} is damaged: its check sum is not that of what it holds')
        content = json.loads(outer['content'])
        if content['declared'] != digest_of(declared):
            raise RecallError(f'{path} is of a twin that was given another model')
        return _memory(content)
    except RecallError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, ParameterError) as error:
        raise RecallError(f'{path} is damaged: {type(error).__name__}: {error}') from None


def _memory(content: Mapping[str, Any]) -> Memory:
    verdict, trial, model = content['verdict'], content['on_trial'], content['model']
    return Memory(
        model and from_values(model), content['calibration'],
        verdict and Verdict(**{**verdict, 'effects': tuple(verdict['effects'])}),
        trial and OnTrial(str(trial[0]), dict(trial[1])))


def set_aside(path: Path) -> Path:
    """Give the file another name, so that a new one can be made; return that. OSError."""
    there = path.with_name(path.name + ASIDE)
    os.replace(path, there)
    return there


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
