"""The priority of a run in real time: the scheduler's own word during it, and plain words where it is not permitted."""

from __future__ import annotations

import ctypes
import json
import os
import sys
from pathlib import Path

import pytest

from orchestration import InputError
from orchestration.session.realtime import prioritized
from tests.commands import orchestrate

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="SCHED_FIFO of Linux")


def permitted() -> bool:
    try:
        with prioritized(1):
            return True
    except InputError:
        return False


@pytest.fixture
def scheduler():
    if not permitted():
        pytest.skip("this user may not have it")


def locked() -> int:
    """kB of this process's memory that are locked, as the kernel counts them."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmLck:")[2].split()[0])


@pytest.mark.usefixtures("scheduler")
def test_the_kernel_has_the_priority_and_the_locked_memory_while_it_lasts_and_not_after():
    before = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
    with prioritized(37):
        assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == (os.SCHED_FIFO, 37)
        assert locked() > 1000
    assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == before
    assert locked() == 0
    with prioritized(None):
        assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == before


def test_a_user_who_may_not_have_it_is_told_the_remedy(monkeypatch):
    def refuse(*arguments):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with (
        pytest.raises(InputError, match="--realtime-priority 80: this user may not have it; remedy: .*rtprio 80"),
        prioritized(80),
    ):
        pytest.fail("it went on without")


@pytest.mark.usefixtures("scheduler")
def test_memory_that_cannot_be_locked_is_told_and_the_priority_is_given_back(monkeypatch):
    class Full:
        def mlockall(self, flags: int) -> int:
            ctypes.set_errno(12)
            return -1

        def munlockall(self) -> int:
            return 0

    before = os.sched_getscheduler(0)
    monkeypatch.setattr(ctypes, "CDLL", lambda *arguments, **more: Full())
    with (
        pytest.raises(InputError, match="the memory cannot be locked: Cannot allocate memory; remedy: .*memlock"),
        prioritized(5),
    ):
        pytest.fail("it went on without")
    assert os.sched_getscheduler(0) == before


def test_other_systems_say_that_they_have_none(monkeypatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(InputError, match="this system has no SCHED_FIFO"), prioritized(80):
        pytest.fail("it went on without")


def test_a_run_that_is_not_in_real_time_has_no_priority(loop):
    told = orchestrate(loop, "--realtime-priority")
    assert (
        told.exit_code,
        "--realtime-priority: only a run in real time has one; remedy: --realtime" in told.stderr,
    ) == (2, True)
    wrong = orchestrate(loop, "--realtime", "--realtime-priority", "100")
    assert (wrong.exit_code, "1<=x<=99" in wrong.stderr) == (2, True), wrong.stderr


@pytest.mark.usefixtures("scheduler")
def test_the_manifest_and_the_summary_of_a_run_have_its_priority(loop, tmp_path):
    done = orchestrate(loop, "--realtime", "10", "--realtime-priority", "42", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "out" / "manifest.json").read_text())["realtime"]["priority"] == 42
    assert "priority 42 (SCHED_FIFO), memory locked" in done.stdout
    assert os.sched_getscheduler(0) == os.SCHED_OTHER
