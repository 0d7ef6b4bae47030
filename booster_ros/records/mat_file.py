# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Read a MATLAB file up to version 7 in a process of its own.

    python -m booster_ros.records.mat_file FILE

It writes the names of the arrays in the file, one JSON list in a line, and the arrays in numpy's
own format; or a sentence to stderr, and ends with 2. A damaged file can break the memory of the
process that scipy reads it in.
"""

from __future__ import annotations

from collections.abc import Sequence
import io
import json
import subprocess
import sys
from typing import Any

import numpy as np

from booster_ros.records.guarded import check_count
from booster_ros.records.record import Array, RecordError
from booster_ros.surroundings import environment_with_package

_DEPTH = 4
_REFUSED = 2


def arrays_in(source: str) -> dict[str, Array]:
    """Return the arrays of numbers in a file, by their paths; RecordError where it is damaged."""
    done = subprocess.run(
        [sys.executable, '-m', __name__, source], stdin=subprocess.DEVNULL, capture_output=True,
        env=environment_with_package(), check=False)
    if done.returncode == _REFUSED:
        raise RecordError(done.stderr.decode(errors='replace').strip())
    if done.returncode:
        raise damaged(source, 'it ends the process that reads it')
    stream = io.BytesIO(done.stdout)
    return {name: np.load(stream, allow_pickle=False) for name in json.loads(stream.readline())}


def damaged(source: str, reason: object) -> RecordError:
    """Return the error for a file that is not what it says."""
    return RecordError(f'{source}: is no readable MATLAB file '
                       f'({" ".join(str(reason).split())[:80]})')


def _read(source: str) -> dict[str, Array]:
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    try:
        shapes = {name: shape for name, shape, _ in whosmat(source)}
        check_count(sum(int(np.prod(shape, dtype=float)) for shape in shapes.values()), source)
        content = loadmat(source, squeeze_me=True, struct_as_record=False)
    except RecordError:
        raise
    except (MatReadError, OSError, ValueError, TypeError, NotImplementedError, MemoryError,
            EOFError, KeyError, IndexError) as error:
        raise damaged(source, error) from None
    found: dict[str, Array] = {}
    for name, value in content.items():
        if not name.startswith('__'):
            _flatten(name, value, found, _DEPTH)
    return found


def _flatten(name: str, value: Any, found: dict[str, Array], depth: int) -> None:
    """Put what is in a variable, and in the fields of a structure, into `found` by their paths."""
    fields = getattr(value, '_fieldnames', None)
    if fields is not None and depth:
        for one in fields:
            _flatten(f'{name}.{one}', getattr(value, one), found, depth - 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in 'iufb':
        found[name] = value


def main(arguments: Sequence[str]) -> int:
    """Write what is in the file that is named; return the exit status."""
    try:
        found = _read(arguments[0])
    except RecordError as error:
        print(error, file=sys.stderr)
        return _REFUSED
    out = sys.stdout.buffer
    out.write(json.dumps(list(found)).encode() + b'\n')
    for values in found.values():
        np.save(out, values, allow_pickle=False)
    out.flush()
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
