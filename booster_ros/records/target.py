# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What writing a file replaces: another file at most, and none that is read."""

from collections.abc import Iterable
import os
from pathlib import Path
import stat

from booster_ros.records.record import RecordError


def replaced_by(path: Path) -> Path:
    """
    Return the file that one written to `path` replaces, links followed; it need not exist.

    RecordError where something else stands there: a new file would take the place of a device or
    a pipe, not go into it.
    """
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    except OSError as error:
        raise RecordError(f'{path} cannot be written: {error.strerror}') from None
    if not stat.S_ISREG(mode):
        kind = 'a folder' if stat.S_ISDIR(mode) else 'no file but a device, a pipe or a socket'
        raise RecordError(f'{path} cannot be written: it is {kind}')
    return Path(os.path.realpath(path))


def check_inputs_stay(inputs: Iterable[Path], targets: Iterable[Path], option: str) -> None:
    """Raise RecordError where a file that is read is to be written too, as `option` asks for."""
    replaced = {os.path.realpath(target) for target in targets}
    for given in inputs:
        if os.path.realpath(given) in replaced:
            raise RecordError(
                f'{given}: is read, and would be overwritten; choose another {option}')
