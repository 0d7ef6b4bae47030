# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Open a table whatever its format, told by how the file begins."""

from __future__ import annotations

import os
import zipfile

from booster_ros.records.guarded import COMPRESSED, check_regular
from booster_ros.records.mapping import Layout
from booster_ros.records.record import RecordError
from booster_ros.records.table import Table

_REFUSED = {
    b'\xd0\xcf\x11\xe0': 'is an old Excel file (.xls); save it as .xlsx',
    b'SQLite': 'is an SQLite data base; give the folder of the bag',
    b'\x89MCAP': 'is an MCAP bag; its name must end in .mcap',
    b'TDSm': 'is a TDMS file; export it as CSV',
    b'%PDF': 'is a PDF',
}


def open_table(path: str | os.PathLike[str], layout: Layout) -> Table:
    """Return the table in a file; RecordError where there is none that can be read."""
    check_regular(path)
    source = os.fspath(path)
    try:
        with open(path, 'rb') as file:
            start = file.read(1024)
    except OSError as error:
        raise RecordError(f'{source}: {error.strerror}') from None
    for mark, what in _REFUSED.items():
        if start.startswith(mark):
            raise RecordError(f'{source}: {what}')
    # what most people do not have is loaded where it is needed
    if start.startswith(b'PK'):
        if not _is_workbook(source):
            raise RecordError(f'{source}: is a zip archive; unpack it')
        from booster_ros.records.sheet_table import open_sheet
        return open_sheet(source, layout)
    if start.startswith((b'PAR1', b'ARROW1', b'FEA1')):
        from booster_ros.records.arrow_table import open_arrow
        return open_arrow(source, start.startswith(b'PAR1'))
    if start.startswith((b'MATLAB 5', b'MATLAB 7.3', b'\x89HDF')):
        from booster_ros.records.mat_table import open_mat
        return open_mat(source, start.startswith(b'MATLAB 5'))
    from booster_ros.records.text_table import open_text
    return open_text(source, layout)


def is_table(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is a table, but no text that is not compressed."""
    if not os.path.isfile(path):  # which a pipe is not: it would wait for what comes
        return False
    try:
        with open(path, 'rb') as file:
            start = file.read(10)
    except OSError:
        return False
    if start.startswith(b'PK'):
        return _is_workbook(os.fspath(path))
    return start.startswith((b'PAR1', b'ARROW1', b'FEA1', b'MATLAB', b'\x89HDF', *COMPRESSED))


def _is_workbook(source: str) -> bool:
    try:
        with zipfile.ZipFile(source) as archive:
            return any(name.startswith('xl/') for name in archive.namelist()[:10_000])
    except (zipfile.BadZipFile, OSError, ValueError):
        return False


def needs(package: str, source: str, purpose: str) -> RecordError:
    """Return the error where a library is not there that a format needs."""
    return RecordError(f'{source}: {purpose} needs the Python package {package}, which is not '
                       f'installed: pip install {package}')
