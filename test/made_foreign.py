# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files with the habits of other people's loggers, and what `inspect` makes of them."""

from pathlib import Path

from booster_ros.records import FileMapping, Record, read_mapping, read_record
from booster_ros.records.inspection import inspect
from booster_ros.records.mapping_text import mapping_text

TRAVEL = 0.02


def rows(count: int = 40) -> list[tuple[int, float, int, float]]:
    """Return time (s), current (A), pressure (Pa) and position (m) of a saw tooth."""
    return [(k, 0.004 + 0.0004 * (k % 10), 20_000 + 2000 * (k % 10), 0.0005 * (k % 10))
            for k in range(count)]


def lines(header: str = 'time,control_current,chamber_pressure,valve_position',
          count: int = 40) -> list[str]:
    """Return the lines of a CSV with these rows."""
    return [header, *(f'{t},{i:.4g},{p},{x:.4g}' for t, i, p, x in rows(count))]


def write(folder: Path, text: str | bytes | list[str], name: str = 'export.csv') -> Path:
    """Return the file with this text."""
    path = folder / name
    if isinstance(text, list):
        text = '\n'.join(text) + '\n'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def mapping_in(path: Path, *edits: tuple[str, str]) -> FileMapping:
    """Return the mapping that `inspect` writes, after at most three edits as of a text editor."""
    assert len(edits) <= 3
    text = mapping_text(inspect(path), path.name)
    for old, new in edits:
        assert old in text, text
        text = text.replace(old, new, 1)
    mapping = path.parent / 'mapping.yaml'
    mapping.write_text(text, encoding='utf-8')
    return read_mapping(mapping)


def mapped(path: Path, *edits: tuple[str, str]) -> Record:
    """Return the record that is read with the mapping of `inspect` after these edits."""
    return read_record(path, mapping=mapping_in(path, *edits), travel=TRAVEL)


def given(folder: Path, text: str) -> FileMapping:
    """Return the mapping that this YAML is."""
    return read_mapping(write(folder, text, 'given.yaml'))
