# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Machine code from the very functions that plain Python runs.

The modules of the model are read in the order in which they build on each other; every function
is compiled by numba with the compiled versions of what it calls in place of the Python ones.
Python calls `kernel.run` alone, so all others are only linked into what calls them.
There is no second copy of an equation. Without numba, `compiled_run` returns None.
"""

from collections.abc import Callable
import functools
import hashlib
import importlib
import importlib.util
import inspect
from pathlib import Path
import sys
import types
from typing import Any

from . import code_cache, linking

_MODULES = ('gas', 'ep_converter', 'booster', 'supply', 'tubing', 'actuator', 'chamber', 'sensors',
            'discrepancy', 'position_controller', 'control_law', 'state', 'present_term', 'system',
            'sticking', 'memory', 'closed_loop', 'outputs', 'workspace', 'rodas3', 'dormand_prince',
            'ahead', 'solver', 'intervals', 'kernel')
# Parameters are a hundred numbers, and a call hands them over one by one: equations that are
# inlined into the steps take half the time. If rodas3 were inlined too, it would be compiled at
# each of its many calls, which takes twice as long and gains nothing.
_INLINED = frozenset(_MODULES) - {
    'workspace', 'rodas3', 'solver', 'kernel', 'position_controller', 'control_law', 'closed_loop'}
_PYTHON = f'py{sys.version_info.major}{sys.version_info.minor}'
_PLAIN = {'new_workspace', 'balance_position'}
_CALLED = ('kernel', 'run')


def available() -> bool:
    """Tell whether the model can be compiled here."""
    return importlib.util.find_spec('numba') is not None


def cache_place() -> code_cache.Place:
    """
    Return the folder for machine code of exactly these sources, see `code_cache.place`.

    The name holds a digest of the sources and of how they are compiled, because numba's own check
    looks at one file only and would keep a function whose callee in another file has changed; it
    also covers the path of the sources, because numba keeps the code of each copy apart, and what
    compiles for which processor.
    """
    import numba
    from numba.core.registry import cpu_target

    here = Path(__file__).parent
    processor = cpu_target.target_context.codegen().magic_tuple()
    digest = hashlib.sha256(f'{here} {numba.__version__} {processor}'.encode())
    for name in ('compiled', 'code_cache', 'linking', *_MODULES):
        digest.update((here / f'{name}.py').read_bytes())
    return code_cache.place(digest.hexdigest()[:16])


def cache_folder() -> Path | None:
    """Return the folder for machine code of exactly these sources, or None where there is none."""
    return cache_place().folder


def is_cached() -> bool:
    """Tell whether the machine code of exactly these sources is already on this machine."""
    folder = cache_folder()
    return folder is not None and any(folder.rglob(f'kernel.run-*.{_PYTHON}.*.nbc'))


def compiled_run() -> Callable[..., None] | None:
    """Return `kernel.run` as machine code (compiled at its first call), or None without numba."""
    modules = compiled_modules()
    return None if modules is None else modules['kernel']['run']


@functools.cache
def compiled_modules() -> dict[str, dict[str, Any]] | None:
    """
    Return the namespace of each module of the model, with its functions for compiled code to call.

    A function is compiled where one that calls it is. Python can call `kernel.run` alone, for the
    others raise TypeError. None without numba.
    """
    if not available():
        return None
    import numba

    folder = cache_folder()
    config: Any = numba.config
    previous = config.CACHE_DIR
    if folder is not None:
        config.CACHE_DIR = str(folder)
    try:
        return _compile_all(numba.njit, folder)
    finally:
        config.CACHE_DIR = previous


def _compile_all(njit: Callable[..., Any], folder: Path | None) -> dict[str, dict[str, Any]]:
    """Return the namespace of each module, functions replaced by machine code kept in a folder."""
    replaced: dict[Any, Any] = {}
    namespaces: dict[str, dict[str, Any]] = {}
    for name in _MODULES:
        module = importlib.import_module(f'{__package__}.{name}')
        names = {key: replaced.get(_identity(value), value) for key, value in
                 vars(module).items()}
        own = {key: value for key, value in vars(module).items()
               if isinstance(value, types.FunctionType) and value.__module__ == module.__name__
               and key not in _PLAIN}
        # in the order of the file: numba looks up what a function calls when it compiles it, at
        # its first call, and by then the namespace holds the compiled versions of all
        for key, value in own.items():
            code = inspect.unwrap(value).__code__  # what plain Python is guarded by it needs not
            twin = types.FunctionType(code, names, key, value.__defaults__)
            twin.__module__ = module.__name__
            twin.__qualname__ = value.__qualname__
            options = {'nogil': True, 'error_model': 'numpy'}
            if (name, key) == _CALLED:
                names[key] = njit(cache=folder is not None, **options)(twin)
                if folder is not None:
                    code_cache.keep_sealed(names[key])
                    code_cache.compile_in_turn(names[key], folder)
            else:
                names[key] = linking.only_linked(
                    njit, twin, forceinline=name in _INLINED, **options)
            replaced[_identity(value)] = names[key]
        namespaces[name] = names
    return namespaces


def _identity(value: Any) -> Any:
    return id(value) if isinstance(value, types.FunctionType) else None
