"""Quotas: what is used up comes back evenly, whoever is limited waits, and memory stays bounded."""

from __future__ import annotations

import threading

import pytest

from server.errors import quota_problem
from server.quotas import DAY, LOCAL, MOST_STRANGERS, Principal, QuotaError, QuotaLimits, Quotas

ANNA, BERT = Principal("anna"), Principal("bert")


class Clock:
    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def refusal(call, *arguments, **options) -> QuotaError:
    with pytest.raises(QuotaError) as caught:
        call(*arguments, **options)
    return caught.value


def test_requests_come_back_at_their_rate(clock):
    quotas = Quotas(QuotaLimits(requests_per_second=2.0, burst=4), clock=clock)
    for _ in range(4):
        quotas.admit(ANNA)
    error = refusal(quotas.admit, ANNA)
    assert (error.limit, error.retry_after) == ("quota_requests_per_second", pytest.approx(0.5))
    quotas.admit(BERT)
    clock.now += 0.49
    refusal(quotas.admit, ANNA)
    clock.now += 0.02
    quotas.admit(ANNA)
    refusal(quotas.admit, ANNA)
    clock.now += 3600.0
    for _ in range(4):
        quotas.admit(ANNA)
    refusal(quotas.admit, ANNA)


def test_over_an_hour_as_many_pass_as_the_rate_allows(clock):
    """Whatever the pattern of asking: the burst and the rate times the time, no more, no less by more than one."""
    quotas, passed = Quotas(QuotaLimits(requests_per_second=3.0, burst=10), clock=clock), 0
    for k in range(36_000):
        clock.now = 1000.0 + 0.1 * k
        try:
            quotas.admit(ANNA)
            passed += 1
        except QuotaError:
            pass
    assert abs(passed - (10 + 3.0 * 3599.9)) <= 1


def test_what_is_promised_is_kept(clock):
    """Who comes again after `retry_after` is admitted."""
    quotas = Quotas(QuotaLimits(requests_per_second=0.7, burst=3, jobs_per_day=2, cases_per_day=50), clock=clock)
    for _ in range(20):
        try:
            quotas.admit(ANNA)
        except QuotaError as error:
            assert error.retry_after is not None
            clock.now += error.retry_after + 1e-9
            quotas.admit(ANNA)
    for _ in range(6):
        try:
            quotas.check_job(ANNA, [], cases=40)
        except QuotaError as error:
            assert error.retry_after is not None
            clock.now += error.retry_after + 1e-6
            quotas.check_job(ANNA, [], cases=40)


def test_bytes_are_counted_after_the_fact_and_waited_for(clock):
    quotas = Quotas(QuotaLimits(body_bytes_per_day=86_400), clock=clock)
    quotas.admit(ANNA)
    quotas.spend_bytes(ANNA, 100_000)
    error = refusal(quotas.admit, ANNA)
    assert error.limit == "quota_body_bytes_per_day"
    assert error.retry_after == pytest.approx(100_000 - 86_400 + 1)
    clock.now += 13_602
    quotas.admit(ANNA)


def test_jobs_wait_for_running_ones_and_for_their_day(clock):
    quotas = Quotas(QuotaLimits(running_jobs=2, jobs_per_day=3, cases_per_day=1000), clock=clock)
    error = refusal(quotas.check_job, ANNA, [None] * 2, cases=1)
    assert (error.limit, error.bound) == ("quota_running_jobs", 2) and error.retry_after
    assert "cancel one" in error.message
    for _ in range(3):
        quotas.check_job(ANNA, [None], cases=10)
    error = refusal(quotas.check_job, ANNA, [], cases=10)
    assert (error.limit, error.retry_after) == ("quota_jobs_per_day", pytest.approx(DAY / 3))
    quotas.check_job(BERT, [], cases=1000)


@pytest.mark.parametrize(
    ("ends", "seconds"),
    [
        ([None, None], 60.0),  # nobody can say
        ([None, 40.0], 40.0),
        ([90.0, 40.0], 40.0),
        ([90.0, 40.0, 7.0], 40.0),  # of three, two must end
        ([None, 40.0, None], 60.0),
        ([1e6, 1e7], 3600.0),  # rates change: ask again within an hour
    ],
)
def test_who_waits_for_jobs_to_end_is_told_when_the_first_will(clock, ends, seconds):
    quotas = Quotas(QuotaLimits(running_jobs=2), clock=clock)
    assert refusal(quotas.check_running, ANNA, ends).retry_after == seconds
    assert refusal(quotas.check_job, ANNA, ends, cases=1).retry_after == seconds


def test_a_job_that_no_waiting_admits_is_told_so_first(clock):
    quotas = Quotas(QuotaLimits(running_jobs=1, jobs_per_day=1, cases_per_day=10), clock=clock)
    quotas.check_job(ANNA, [], cases=1)
    error = refusal(quotas.check_job, ANNA, [None], cases=11)
    assert (error.limit, error.retry_after) == ("quota_cases_per_day", None)


def test_a_refused_job_uses_nothing_up(clock):
    quotas = Quotas(QuotaLimits(jobs_per_day=2, cases_per_day=100), clock=clock)
    for _ in range(5):
        error = refusal(quotas.check_job, ANNA, [], cases=101)
        assert error.retry_after is None and "split it" in error.message
    quotas.check_job(ANNA, [], cases=99)
    error = refusal(quotas.check_job, ANNA, [], cases=2)
    assert (error.limit, error.retry_after) == ("quota_cases_per_day", pytest.approx(DAY / 100))
    quotas.check_job(ANNA, [], cases=1)


def test_who_is_not_limited_never_waits(clock):
    limits = QuotaLimits(0.001, burst=1, running_jobs=1, jobs_per_day=1, cases_per_day=1, body_bytes_per_day=1)
    for quotas, who in ((Quotas(limits, clock=clock), LOCAL), (Quotas(QuotaLimits(), clock=clock), ANNA)):
        for _ in range(100):
            quotas.admit(who)
            quotas.spend_bytes(who, 10**12)
            quotas.check_job(who, [None] * 1000, cases=10**12)


def test_strangers_are_forgotten_but_tokens_are_not(clock):
    quotas = Quotas(QuotaLimits(requests_per_second=1e-6, burst=1), clock=clock)
    quotas.admit(ANNA)
    for k in range(2 * MOST_STRANGERS):
        quotas.admit_stranger(f"2001:db8::{k:x}")
    assert len(quotas._strangers) == MOST_STRANGERS
    refusal(quotas.admit_stranger, f"2001:db8::{2 * MOST_STRANGERS - 1:x}")
    refusal(quotas.admit, ANNA)


def test_threads_share_one_count():
    quotas, passed = Quotas(QuotaLimits(requests_per_second=1e-9, burst=500)), []

    def ask_often() -> None:
        for _ in range(200):
            try:
                quotas.admit(ANNA)
                passed.append(1)
            except QuotaError:
                pass

    threads = [threading.Thread(target=ask_often) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(passed) == 500


def test_a_quota_error_says_when_or_that_nothing_helps():
    waits = quota_problem(QuotaError("wait", limit="quota_burst", bound=1, retry_after=0.2))
    assert (waits.status_code, waits.headers["retry-after"]) == (429, "1")
    never = quota_problem(QuotaError("too large", limit="quota_burst", bound=1, retry_after=None))
    assert never.status_code == 413 and "retry-after" not in never.headers
