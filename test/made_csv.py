# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""CSV records made of good lines, for tests of what is read from them."""

from pathlib import Path

from booster_ros.records import read_record

HEADER = 'time,control_current,chamber_pressure,valve_position'


def good_lines(rows: int = 50) -> list[str]:
    """Return the lines of a CSV in which everything is as it should be."""
    return [HEADER] + [
        f'{row / 100:.2f},{4e-4 + 1e-6 * (row // 10):.9f},{150_000 + 100 * row},{row * 2e-6:.6f}'
        for row in range(rows)
    ]


def write(folder: Path, text: str | bytes) -> Path:
    """Return the file with this text."""
    path = folder / 'record.csv'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read_lines(folder: Path, lines: list[str]):
    """Return the record in a file of these lines."""
    return read_record(write(folder, '\n'.join(lines) + '\n'))


def replaced(row: int, line: str) -> list[str]:
    """Return good lines with one replaced, counted as an editor does."""
    lines = good_lines()
    lines[row - 1] = line
    return lines


def defects(record, kind: str):
    """Return what was noted of this kind."""
    return [defect for defect in record.defects if defect.kind == kind]
