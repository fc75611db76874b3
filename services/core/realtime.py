"""What the operating system is asked for: priority, exact sleeps, and death with the parent."""

import ctypes
import gc
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager

PR_SET_PDEATHSIG = 1
PR_SET_TIMERSLACK = 29
EXACT_NS = 1  # the default slack makes every sleep 50 us late


def request_scheduling(fifo_priority: int, nice: int) -> str:
    """Ask for SCHED_FIFO at a priority (0 = do not), else for a niceness; returns what we got.

    Threads that are made afterwards inherit it, so call this before a Zenoh session is opened.
    """
    _prctl(PR_SET_TIMERSLACK, EXACT_NS)
    refused = ""
    if fifo_priority > 0:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(fifo_priority))
        except PermissionError:
            refused = " (SCHED_FIFO not permitted)"
        else:
            return f"SCHED_FIFO {fifo_priority}"
    try:
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    except PermissionError:
        refused = refused or f" (nice {nice} not permitted)"
    return f"nice {os.getpriority(os.PRIO_PROCESS, 0)}{refused}"


@contextmanager
def ordinary_scheduling() -> Iterator[None]:
    """This thread at no priority meanwhile: compiling must not keep the machine from all else."""
    policy, param = os.sched_getscheduler(0), os.sched_getparam(0)
    if policy != os.SCHED_FIFO:
        yield
        return
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, param)


def freeze_garbage() -> None:
    """Keep the collector off all that exists by now: a pass over it takes milliseconds."""
    gc.collect()
    gc.freeze()


def die_with_parent(parent_pid: int) -> bool:
    """Have the kernel send us SIGTERM when the parent ends; False if it has ended already."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    return os.getppid() == parent_pid


def _prctl(option: int, value: int) -> None:
    """Linux only; elsewhere the defaults stay."""
    prctl = getattr(ctypes.CDLL(None), "prctl", None)
    if prctl is not None:
        prctl(option, ctypes.c_ulong(value), 0, 0, 0)
