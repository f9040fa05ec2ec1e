"""Time limits of quick runs: one thread for all, which stops what is late and nothing else."""

from __future__ import annotations

import threading
import time

import pytest

from server.time_limits import TimeLimits

PATIENCE = 30.0
LONG = 3600.0


def test_what_takes_too_long_is_stopped_once():
    limits, stops = TimeLimits(), []
    late = threading.Event()

    def stop() -> None:
        stops.append(time.monotonic())
        late.set()

    began = time.monotonic()
    with limits.within(0.05, stop):
        assert late.wait(PATIENCE)
        time.sleep(0.1)
    assert len(stops) == 1 and stops[0] - began >= 0.05


def test_what_is_done_in_time_is_not_stopped():
    limits, stops = TimeLimits(), []
    with pytest.raises(ZeroDivisionError), limits.within(0.05, lambda: stops.append(1)):
        _ = 1 // 0
    with limits.within(0.05, lambda: stops.append(2)):
        pass
    late = threading.Event()
    with limits.within(0.2, late.set):
        assert late.wait(PATIENCE)
    assert stops == []


def test_an_earlier_limit_is_not_kept_waiting_by_a_later_one():
    limits, late = TimeLimits(), threading.Event()
    with limits.within(LONG, late.clear):
        time.sleep(0.05)  # by now the thread sleeps until then
        with limits.within(0.05, late.set):
            assert late.wait(PATIENCE)


def test_many_share_one_thread():
    limits, before = TimeLimits(), threading.active_count()
    events = [threading.Event() for _ in range(50)]
    for event in events:
        with limits.within(LONG, event.set):
            pass
    assert threading.active_count() == before + 1 and not any(event.is_set() for event in events)
