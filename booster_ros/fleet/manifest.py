# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The manifest of a fleet: a CSV with a row for each valve."""

from __future__ import annotations

import csv
from dataclasses import dataclass
import hashlib
from pathlib import Path
import re

from ..running.run_error import RunError

PATHS = ('record', 'parameters', 'mapping', 'validation', 'validation_mapping')
"""Columns that hold paths, beside `valve`, its name."""

_NEEDED = ('record', 'parameters')
_NAME = re.compile(r'\w[\w .+@=-]*')
_LARGEST = 64 << 20


class FleetError(RunError):
    """A fleet makes no sense; the message is one sentence."""


@dataclass(frozen=True)
class Valve:
    """A valve: its name, and files as the manifest gives them, relative to its folder; '' none."""

    name: str
    record: str
    parameters: str
    mapping: str = ''
    validation: str = ''
    validation_mapping: str = ''

    def words(self) -> list[str]:
        """Return the arguments of `close_loop` but for where it writes."""
        options = ('--record', '--params', '--map', '--validation', '--validation-map')
        return [word for option, column in zip(options, PATHS) if getattr(self, column)
                for word in (option, getattr(self, column))]

    def digest(self, folder: Path, more: tuple[str, ...]) -> str:
        """Return what identifies the contents of all files, and the options, of a diagnosis."""
        found = hashlib.sha256(repr((self, more)).encode())
        for column in PATHS:
            if getattr(self, column):
                _add(found, folder / getattr(self, column))
        return found.hexdigest()[:16]


def read_manifest(path: Path) -> list[Valve]:
    """Return the valves of a manifest; FleetError where a row, or the whole, makes no sense."""
    try:
        if not path.is_file():
            raise FleetError(f'{path}: is no file')
        if path.stat().st_size > _LARGEST:
            raise FleetError(f'{path}: is larger than 64 MB, which no manifest is')
        with path.open(encoding='utf-8-sig', newline='') as file:
            rows = list(csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FleetError(f'{path}: is no CSV in UTF-8 ({error})') from None
    head = [name.strip().lower() for name in rows[0]] if rows else []
    _check_head(head, path)
    valves: list[Valve] = []
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(head):
            raise FleetError(f'{path}, row {number}: has {len(row)} cells, the header {len(head)}')
        given = {name: cell.strip() for name, cell in zip(head, row)}
        valves.append(_valve(given, {one.name for one in valves}, f'{path}, row {number}'))
    if not valves:
        raise FleetError(f'{path}: has no valve')
    return valves


def _check_head(head: list[str], path: Path) -> None:
    known = ('valve', *PATHS)
    for name in head:
        if name not in known:
            raise FleetError(f'{path}: {name[:60]!r} is no column of a manifest; there are '
                             f'{", ".join(known)}')
    for name in _NEEDED:
        if name not in head:
            raise FleetError(f'{path}: there is no column {name}; a manifest has '
                             f'{", ".join(known)}, of which record and parameters are needed')
    if len(set(head)) < len(head):
        raise FleetError(f'{path}: a column is there twice')


def _valve(given: dict[str, str], taken: set[str], where: str) -> Valve:
    for name in _NEEDED:
        if not given[name]:
            raise FleetError(f'{where}: {name} is empty')
    name = given.pop('valve', '') or Path(given['record']).stem
    if not _NAME.fullmatch(name) or len(name) > 100:
        raise FleetError(f'{where}: {name[:60]!r} cannot be the name of a folder; use letters, '
                         'digits, spaces and . + - = @ _')
    if name in taken:
        raise FleetError(f'{where}: there is a valve {name} already; give each a name of its own '
                         'in the column valve')
    if given.get('validation_mapping') and not given.get('validation'):
        raise FleetError(f'{where}: has a validation_mapping and no validation')
    return Valve(name, **given)


def _add(found: hashlib._Hash, path: Path) -> None:
    """Add the contents of a file, or of all in a folder; one that is not there counts as such."""
    if path.is_dir():
        for one in sorted(path.rglob('*')):
            found.update(one.relative_to(path).as_posix().encode())
            if one.is_file():
                _add(found, one)
    elif path.is_file():
        with path.open('rb') as file:
            while part := file.read(1 << 20):
                found.update(part)
    else:
        found.update(b'not a file')
