# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A fleet on Dask: on workers of this machine, or of a scheduler that runs already."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
import importlib
import logging
import signal
import threading
from typing import Any

from .manifest import FleetError
from .outcome import FAILED, Outcome
from .work import Order, stop_run

AHEAD = 2
"""Orders that wait for each worker: so many are told at a time, however many valves there are."""

GLANCE = 0.5
"""Time from one look for an interruption to the next, s."""

_PATIENCE = '10s'


def run_orders(
    orders: Sequence[Order], scheduler: str, jobs: int, tell: Callable[[Outcome], None],
    check: Callable[[], None],
) -> None:
    """
    Run orders on a scheduler, by address, or on `jobs` processes of this machine where it is ''.

    `tell` hears of each outcome, in this thread; `check` may raise KeyboardInterrupt: then what
    runs is ended, and nothing is told of it. FleetError where there is no Dask or no scheduler.
    """
    if not orders:
        return
    with _client(scheduler, min(jobs, len(orders))) as client:
        left = iter(orders)
        waiting: dict[Any, Order] = {}
        try:
            _submit(client, left, waiting)
            while waiting:
                for future in _ended(client, list(waiting)):
                    outcome = _outcome(future, waiting.pop(future))
                    if outcome is not None:
                        tell(outcome)
                    _submit(client, left, waiting)
                check()
        except BaseException:
            client.cancel(list(waiting), force=True)
            client.run(stop_run, orders[0].run, on_error='ignore')
            raise


def _submit(client: Any, left: Iterator[Order], waiting: dict[Any, Order]) -> None:
    threads = sum(client.nthreads().values()) or 1
    while len(waiting) < (1 + AHEAD) * threads:
        order = next(left, None)
        if order is None:
            return
        waiting[client.submit(_launcher(), asdict(order), pure=False,
                              key=f'{order.valve.name}-{order.run}')] = order


def _launcher() -> Callable[[dict[str, Any]], Any]:
    """
    Return what is submitted: a function of plain values that goes by value.

    A scheduler looks into what it is told, and need not have this package; its workers must.
    """
    def launched(values: dict[str, Any]) -> Any:
        import importlib

        return importlib.import_module('booster_ros.fleet.work').diagnosed(values)

    return launched


def _ended(client: Any, futures: list[Any]) -> list[Any]:
    """Return the futures that have ended after a glance at most."""
    distributed = importlib.import_module('distributed')
    try:
        return list(distributed.wait(futures, timeout=GLANCE, return_when='FIRST_COMPLETED').done)
    except TimeoutError:
        if client.status != 'running':
            raise FleetError('the scheduler has ended; the same command goes on from here'
                             ) from None
        return []


def _outcome(future: Any, order: Order) -> Outcome | None:
    """Return what came of a future; a worker that died, or knows no such package, is told."""
    try:
        found: Outcome | None = future.result()
    except Exception as error:  # of the worker, whatever it is
        text = ' '.join(str(error).split()) or type(error).__name__
        return Outcome(order.valve.name, order.inputs, order.state, FAILED,
                       f'a worker failed: {text[:200]}')
    return found


@contextmanager
def _not_for_children() -> Iterator[None]:
    """
    Keep Ctrl-C, and the end of a terminal, from processes that are started within.

    Both go to all processes of a terminal. A worker that ends by itself cannot be told any more to
    end the diagnoses that it runs. What comes within the second that this takes is lost.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept = {number: signal.signal(number, signal.SIG_IGN)
            for number in (signal.SIGINT, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


@contextmanager
def _client(scheduler: str, jobs: int) -> Iterator[Any]:
    """Yield a client of the scheduler, or of workers that end with it."""
    try:
        distributed = importlib.import_module('distributed')
    except ModuleNotFoundError as missing:
        raise FleetError(f'a fleet needs the Python package {missing.name}, which is not '
                         "installed: pip install 'distributed'") from None
    logging.getLogger('distributed').setLevel(logging.CRITICAL)
    with ExitStack() as stack:
        target: Any = scheduler
        if not scheduler:
            with _not_for_children():
                target = stack.enter_context(distributed.LocalCluster(
                    n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None,
                    silence_logs=logging.CRITICAL))
        try:
            client = stack.enter_context(distributed.Client(target, timeout=_PATIENCE))
            if scheduler:
                client.wait_for_workers(1, timeout=10)
        except (OSError, TimeoutError, ValueError) as error:
            said = ' '.join(str(error).split())[:160]
            raise FleetError(f'--scheduler: {scheduler} does not answer, or has no workers '
                             f'({said})') from None
        yield client
