# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many orders on Dask: on workers of this process, or of a scheduler that runs already."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
import importlib
import logging
from typing import Any
import uuid

from .orders import stop_run
from .run_error import RunError

AHEAD = 2
"""Orders that wait for each worker: so many are told at a time, however many there are."""

GLANCE = 0.5
"""Time from one look for an interruption to the next, s."""

_PATIENCE = '10s'

Tell = Callable[[Any], None]
Fail = Callable[[str, str], None]


def run_orders(
    function: str, orders: Mapping[str, Mapping[str, Any]], scheduler: str, jobs: int, tell: Tell,
    fail: Fail, check: Callable[[], None],
) -> None:
    """
    Carry out orders, by name, on a scheduler, or `jobs` at a time in this process if that is ''.

    `function`, named as 'module:function', gets the plain values of an order and an event that
    tells it to end; what runs long is a process that it starts. In this thread, `tell` hears of
    what it returns, unless that is None, and `fail` of an order, by name, whose worker died or
    raised. `check` may raise KeyboardInterrupt: then what runs is ended, and nothing is told of it.
    RunError where there is no Dask or no scheduler.
    """
    if not orders:
        return
    run = uuid.uuid4().hex[:12]
    with _client(scheduler, min(jobs, len(orders))) as client:
        left = enumerate(orders.items())
        waiting: dict[Any, str] = {}

        def submit() -> None:
            threads = sum(client.nthreads().values()) or 1
            while len(waiting) < (1 + AHEAD) * threads:
                number, (name, values) = next(left, (0, ('', None)))
                if values is None:
                    return
                waiting[client.submit(_launcher(), run, function, values, pure=False,
                                      key=f'{name}-{run}', priority=-number)] = name

        try:
            submit()
            while waiting:
                for future in _ended(client, list(waiting)):
                    _hear(future, waiting.pop(future), tell, fail)
                    submit()
                check()
        except BaseException:
            client.cancel(list(waiting), force=True)
            client.run(stop_run, run, on_error='ignore')
            raise


def _launcher() -> Callable[[str, str, Mapping[str, Any]], Any]:
    """
    Return what is submitted: a function of plain values that goes by value.

    A scheduler looks into what it is told, and need not have this package; its workers must.
    """
    def launched(run: str, function: str, values: Mapping[str, Any]) -> Any:
        import importlib

        return importlib.import_module('booster_ros.running.orders').carried_out(
            run, function, values)

    return launched


def _ended(client: Any, futures: list[Any]) -> list[Any]:
    """Return the futures that have ended after a glance at most."""
    distributed = importlib.import_module('distributed')
    try:
        return list(distributed.wait(futures, timeout=GLANCE, return_when='FIRST_COMPLETED').done)
    except TimeoutError:
        if client.status != 'running':
            raise RunError('the scheduler has ended; the same command goes on from here') from None
        return []


def _hear(future: Any, name: str, tell: Tell, fail: Fail) -> None:
    """Tell what came of a future; a worker that died, or knows no such package, is a failure."""
    try:
        found = future.result()
    except Exception as error:  # of the worker, whatever it is
        text = ' '.join(str(error).split()) or type(error).__name__
        fail(name, f'a worker failed: {text[:200]}')
        return
    if found is not None:
        tell(found)


@contextmanager
def _client(scheduler: str, jobs: int) -> Iterator[Any]:
    """
    Yield a client of the scheduler, or of a worker with `jobs` threads that ends with it.

    That worker is in this process: its threads only wait for the processes that they start.
    """
    try:
        distributed = importlib.import_module('distributed')
    except ModuleNotFoundError as missing:
        raise RunError(f'many runs need the Python package {missing.name}, which is not '
                       'installed: pip install distributed') from None
    for name in ('distributed', 'asyncio'):  # of a wait that was interrupted, what nobody waits for
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with ExitStack() as stack:
        target: Any = scheduler
        if not scheduler:
            # a port of its own: of one that a second run on this machine has taken already, the
            # scheduler warns, and loses a socket
            target = stack.enter_context(distributed.LocalCluster(
                n_workers=1, threads_per_worker=jobs, processes=False, memory_limit=None,
                dashboard_address=None, silence_logs=logging.CRITICAL,
                scheduler_kwargs={'dashboard_address': ':0'}))
        try:
            client = stack.enter_context(distributed.Client(target, timeout=_PATIENCE))
            if scheduler:
                client.wait_for_workers(1, timeout=10)
        except (OSError, TimeoutError, ValueError) as error:
            said = ' '.join(str(error).split())[:160]
            raise RunError(f'--scheduler: {scheduler} does not answer, or has no workers '
                           f'({said})') from None
        yield client
