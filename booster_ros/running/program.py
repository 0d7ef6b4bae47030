# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that is judged: of this checkout or of another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
import hashlib
import json
import os
from pathlib import Path
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
from typing import NamedTuple

from .run_error import RunError

MODULE = 'booster_ros'

APART = ('campaign', 'fleet', 'running', 'programs/campaign.py', 'programs/fleet.py', 'nodes',
         'benchmark', 'measured', 'paper')
"""Parts of the package that no diagnosis comes through: a change there changes no answer."""

SETTINGS = ('OPENBLAS_', 'OMP_', 'MKL_', 'NUMBA_')
"""How the names of variables begin by which libraries choose kernels and threads."""

PATH = 'PYTHONPATH'
"""Another variable that an answer may hang on: where Python finds a package."""

GLANCE = 0.2
"""Time from one look for an end to the next, s."""

_PROBE = f"""
import importlib.metadata, json, platform, {MODULE}
libraries = {{}}
for name in ('numpy', 'scipy', 'numba'):
    try:
        libraries[name] = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        libraries[name] = None
print(json.dumps([list({MODULE}.__path__)[0], platform.python_version(), libraries]))
"""


class Ended(NamedTuple):
    """
    How a run ended: its status, None where it was stopped; what it said last; seconds.

    `cpu_seconds` is what it took of all cores, with what it started: other than `seconds`, that
    depends little on what else the machine does.
    """

    status: int | None
    said: str
    seconds: float
    cpu_seconds: float


@dataclass(frozen=True)
class Program:
    """
    `python -m booster_ros` of some checkout: its words, and the folder in which it runs.

    `variables` are those an answer may hang on, as they are where the program was asked for: its
    runs get these and no others, wherever they run.
    """

    words: tuple[str, ...]
    folder: Path
    package: Path
    libraries: str
    variables: Mapping[str, str]

    def run(self, name: str, words: Sequence[str | Path], timeout: float, stop: threading.Event
            ) -> Ended:
        """Run one of its programs to the end, for `timeout` seconds, or until `stop` is set."""
        others = {name: value for name, value in os.environ.items()
                  if name not in deciding(os.environ)}
        started = time.monotonic()
        with tempfile.TemporaryFile() as sink:
            process = subprocess.Popen(
                [*self.words, name, *map(str, words)], cwd=self.folder,
                env={**others, **self.variables}, stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=sink, start_new_session=True)
            stopped = False
            while (ended := _reaped(process, 0 if stopped else os.WNOHANG)) is None:
                stopped = stop.wait(GLANCE) or time.monotonic() - started > timeout
                if stopped:
                    _kill(process)
            sink.seek(0)
            lines = sink.read().decode(errors='replace').strip().splitlines()
        status, cpu_seconds = ended
        return Ended(None if stopped else status, lines[-1] if lines else '',
                     time.monotonic() - started, cpu_seconds)

    def state(self) -> str:
        """Return what identifies the sources, libraries and settings that make an answer."""
        found = hashlib.sha256(json.dumps([self.libraries, settings(self.variables)]).encode())
        for path in sorted(self.package.rglob('*')):
            name = path.relative_to(self.package).as_posix()
            if path.suffix in ('.py', '.html', '.csv') and not any(
                    name == part or name.startswith(f'{part}/') for part in APART):
                found.update(name.encode())
                with suppress(FileNotFoundError):  # another checkout may be changed meanwhile
                    found.update(path.read_bytes())
        return found.hexdigest()[:16]

    def described(self) -> str:
        """Return the last commit of the checkout with its subject, empty outside a repository."""
        done = subprocess.run(
            ['git', '-C', str(self.package), 'log', '-1', '--format=%h %s'],
            capture_output=True, text=True, check=False) if _has_git() else None
        if done is None or done.returncode:
            return ''
        changed = subprocess.run(
            ['git', '-C', str(self.package), 'status', '--porcelain', '--', '.'],
            capture_output=True, text=True, check=False).stdout.strip()
        return done.stdout.strip() + (' (with changes)' if changed else '')


def program_of(text: str, folder: Path | None) -> Program:
    """
    Return the program that a command line starts, empty for the python that runs this.

    RunError where it does not start, or is not of the form `PYTHON -m booster_ros`.
    """
    words = tuple(shlex.split(text)) or (sys.executable, '-m', MODULE)
    where = (folder or Path()).resolve()
    if words[-2:] != ('-m', MODULE) or len(words) < 3:
        raise RunError(f'--program: {text!r} is not of the form PYTHON -m {MODULE}')
    if not where.is_dir():
        raise RunError(f'--cwd: there is no folder {folder}')
    try:
        done = subprocess.run([*words[:-2], '-c', _PROBE], cwd=where, capture_output=True,
                              text=True, check=False)
    except OSError as error:
        raise RunError(f'--program: {words[0]}: {error.strerror}') from None
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [''])[-1]
        raise RunError(f'--program: {text or words[0]} does not start in {where}: {last}')
    package, python, libraries = json.loads(done.stdout)
    return Program(words, where, where / package, json.dumps([python, libraries], sort_keys=True),
                   deciding(os.environ))


def settings(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables by which libraries choose kernels and threads."""
    return {name: environment[name] for name in sorted(environment)
            if name.startswith(SETTINGS)}


def deciding(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables that an answer may hang on: the settings and Python's path."""
    path = {PATH: environment[PATH]} if PATH in environment else {}
    return {**settings(environment), **path}


def _has_git() -> bool:
    return any(os.access(Path(folder) / 'git', os.X_OK) for folder in os.get_exec_path())


def _reaped(process: subprocess.Popen[bytes], flags: int) -> tuple[int, float] | None:
    """Return status and CPU seconds of a process that has ended, None if it has not."""
    pid, status, usage = os.wait4(process.pid, flags)
    if not pid:
        return None
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_utime + usage.ru_stime


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a process with all that it has started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
