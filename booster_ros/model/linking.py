# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Functions that only other compiled functions call: linked into them, with no code of their own.

numba makes machine code of every function that it compiles, with all that it calls linked in, and
a wrapper by which Python calls it. Of functions that call each other ten deep that is ten times the
work, for code that nobody runs. Here they stay in LLVM's intermediate representation; the function
that Python calls is optimised with all of them in it, once.
"""

from collections.abc import Callable
import functools
from typing import Any


def only_linked(njit: Callable[..., Any], function: Callable[..., Any], **options: Any) -> Any:
    """Return the function for compiled ones to call, by numba's `njit` with these options."""
    dispatcher = njit(pipeline_class=_pipeline(), no_cpython_wrapper=True, no_cfunc_wrapper=True,
                      **options)(function)
    dispatcher.__class__ = _linked_dispatcher(type(dispatcher))  # type: ignore[arg-type]
    return dispatcher


@functools.cache
def _linked_dispatcher(base: Any) -> Any:
    """Return the class of a function that refuses to be called: it has no entry for Python."""

    class Linked(base):

        def __call__(self, *arguments: Any) -> None:
            raise TypeError(f'{self.py_func.__qualname__} is compiled only into what calls it')

    return Linked


@functools.cache
def _pipeline() -> Any:
    """Return the compiler of such functions: numba's own, with a library that is only linked."""
    from numba.core import compiler
    from numba.core.compiler_machinery import FunctionPass, register_pass
    from numba.core.untyped_passes import TranslateByteCode

    @register_pass(mutates_CFG=False, analysis_only=False)
    class GiveLibrary(FunctionPass):
        """Give the function its library, where numba would make one that is run."""

        _name = 'give_library_that_is_only_linked'

        def __init__(self) -> None:
            super().__init__()

        def run_pass(self, state: Any) -> bool:
            state.library = _library()(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
            return False

    class LinkedCompiler(compiler.CompilerBase):

        def define_pipelines(self) -> list[Any]:
            passes = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
            passes.add_pass_after(GiveLibrary, TranslateByteCode)
            passes.finalize()
            return [passes]

    return LinkedCompiler


@functools.cache
def _library() -> Any:
    from numba.core.codegen import JITCodeLibrary

    class LinkedLibrary(JITCodeLibrary):
        """Code that is not optimised and not made machine code, until it is linked elsewhere."""

        @property
        def codegen(self) -> Any:
            return _NoEnvironment

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

        def _optimize_final_module(self) -> None:
            pass

        def _finalize_final_module(self) -> None:
            self._finalized = True

    return LinkedLibrary


class _NoEnvironment:
    """What numba tells a function's environment, which code for Python alone looks at."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing."""
