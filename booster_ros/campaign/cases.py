# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sets of records with known truth: folders of CASE.yaml, CASE_fit.csv, CASE_val.csv, key.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch
import hashlib
import json
from pathlib import Path
from typing import Any

from ..running.run_error import RunError

NOISE: Mapping[str, float] = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
"""Noise of the channels (RMS, Pa and m) where the key of a set does not state its own."""

QUICK = 60
"""How many cases a quick campaign has at the most."""


class CampaignError(RunError):
    """A campaign makes no sense; the message is one sentence for the user."""


@dataclass(frozen=True)
class Truth:
    """
    What is hidden in a case.

    Each of `names` counts as right; 'a+b' asks for both, 'none' for nothing, and 'unknown' for a
    term without a name. `location` has 'a+b' for two places and 'a|b' where either is right.
    `noise` is the RMS noise by channel, `parameters` are true values by the model's names; both in
    SI units.
    """

    names: tuple[str, ...]
    location: str
    noise: Mapping[str, float] = field(default_factory=lambda: dict(NOISE))
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_clean(self) -> bool:
        """Whether nothing is hidden."""
        return self.names == ('none',)


@dataclass(frozen=True)
class Case:
    """One case of a set: its files are FOLDER/NAME.yaml and the two records FOLDER/NAME_*.csv."""

    set: str
    name: str
    folder: Path
    truth: Truth

    @property
    def key(self) -> tuple[str, str]:
        """The names of set and case."""
        return self.set, self.name

    @property
    def declared(self) -> Path:
        """The declared parameters."""
        return self.folder / f'{self.name}.yaml'

    @property
    def record(self) -> Path:
        """The record that is shown to the diagnosis."""
        return self.folder / f'{self.name}_fit.csv'

    @property
    def other(self) -> Path:
        """The record by which the written model is judged."""
        return self.folder / f'{self.name}_val.csv'

    def digest(self) -> str:
        """Return what identifies the case's files and its truth."""
        found = hashlib.sha256(repr((
            self.truth.names, self.truth.location, sorted(self.truth.noise.items()),
            sorted(self.truth.parameters.items()))).encode())
        for path in (self.declared, self.record, self.other):
            found.update(path.read_bytes() if path.exists() else b'')
        return found.hexdigest()[:16]


def read_sets(folders: Sequence[Path]) -> list[Case]:
    """Return all cases of some sets; CampaignError where one is none or two have one name."""
    cases: list[Case] = []
    seen: dict[str, Path] = {}
    for folder in folders:
        name = folder.resolve().name
        if name in seen:
            raise CampaignError(f'{folder}: a set with the name of {seen[name]}; rename one')
        seen[name] = folder
        cases += read_set(folder)
    return cases


def read_set(folder: Path) -> list[Case]:
    """Return the cases of a set by name; CampaignError where it is none."""
    path = folder / 'key.json'
    try:
        key = json.loads(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise CampaignError(f'{path}: {error.strerror}; a set has a key.json') from None
    except ValueError as error:
        raise CampaignError(f'{path}: is not JSON: {error}') from None
    if not isinstance(key, dict) or not key:
        raise CampaignError(f'{path}: has no cases')
    found = folder.resolve()
    return [Case(found.name, name, found, _truth(f'{path}: {name}', key[name]))
            for name in sorted(key)]


def _truth(where: str, entry: Any) -> Truth:
    """Return the truth from an entry of a key; CampaignError, which begins with `where`."""
    if not isinstance(entry, dict):
        raise CampaignError(f'{where}: is no entry with names and location')
    names, location = entry.get('names'), entry.get('location')
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise CampaignError(f'{where}: names has to be a list of names of effects')
    if not isinstance(location, str):
        raise CampaignError(f'{where}: location has to be a text')
    return Truth(tuple(names), location,
                 {**NOISE, **_numbers(where, entry, 'noise')},
                 _numbers(where, entry, 'parameters'))


def _numbers(where: str, entry: dict[str, Any], name: str) -> dict[str, float]:
    values = entry.get(name, {})
    if not isinstance(values, dict) or not all(
            isinstance(v, int | float) and not isinstance(v, bool) for v in values.values()):
        raise CampaignError(f'{where}: {name} has to be numbers by name')
    return {key: float(value) for key, value in values.items()}


def chosen(cases: Sequence[Case], patterns: Sequence[str], quick: bool) -> list[Case]:
    """
    Return the cases whose names match one of the patterns, all if there are none.

    Of more than QUICK, a quick campaign has so many, spread evenly. CampaignError if none is left.
    """
    left = [case for case in cases
            if not patterns or any(fnmatch(case.name, pattern) for pattern in patterns)]
    if not left:
        raise CampaignError(f'no case is called {" or ".join(patterns)}')
    if quick and len(left) > QUICK:
        left = [left[k * len(left) // QUICK] for k in range(QUICK)]
    return left
