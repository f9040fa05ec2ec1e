"""Owns what each user of the API may use: requests, bytes and jobs, counted in this process. It knows no HTTP.

Allowances refill evenly, so a quota a day is what any day long may use beyond what was saved up. Counters start afresh
with the process.
"""

from __future__ import annotations

import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

DAY = 86_400.0
UNKNOWN_END, LONGEST_WAIT = 60.0, 3600.0
"""After so long one who waits for jobs to end should ask again: where no rate tells when, and at the latest, s."""
MOST_STRANGERS = 4096
"""Addresses remembered that brought a wrong token; the longest silent is forgotten first."""


@dataclass(frozen=True)
class Principal:
    """Who asks: a token's name, or `local` where the program demands none."""

    name: str
    limited: bool = True


LOCAL = Principal("local", limited=False)
NOBODY = Principal("-", limited=False)
"""Who asks where tokens are demanded, for what needs none."""


@dataclass(frozen=True)
class QuotaLimits:
    """What each token may use; 0 is no limit."""

    requests_per_second: float = 0.0
    burst: int = 1
    running_jobs: int = 0
    jobs_per_day: int = 0
    cases_per_day: int = 0
    body_bytes_per_day: int = 0


class QuotaError(Exception):
    """A quota is used up.

    Attributes
    ----------
    limit : the setting that says so, without its prefix, and its value in `bound`.
    retry_after : seconds after which the same request is admitted, for jobs to end an estimate; None where it never is.

    """

    def __init__(self, message: str, *, limit: str, bound: float, retry_after: float | None) -> None:
        super().__init__(message)
        self.message, self.limit, self.bound, self.retry_after = message, limit, bound, retry_after


class _Allowance:
    """An allowance of `size` that is full at first and refills by `rate` a second; no limit where `rate` is 0."""

    def __init__(self, size: float, rate: float, now: float) -> None:
        self.size, self._rate = size, rate
        self._level, self._at = size, now

    def wait(self, amount: float, now: float) -> float:
        """Return the seconds until `amount` can be taken, 0 where it can now; infinite where it exceeds the size."""
        if self._rate <= 0.0:
            return 0.0
        if self.never(amount):
            return math.inf
        self._level = min(self.size, self._level + (now - self._at) * self._rate)
        self._at = now
        return max(0.0, (amount - self._level) / self._rate)

    def never(self, amount: float) -> bool:
        """Whether no waiting makes room for `amount`."""
        return 0.0 < self._rate and amount > self.size

    def take(self, amount: float) -> None:
        """Take what `wait` said is there; what is spent afterwards may go below zero and is waited for."""
        self._level -= amount


class _Account:
    """The allowances of one principal."""

    def __init__(self, limits: QuotaLimits, now: float) -> None:
        self.requests = _Allowance(limits.burst, limits.requests_per_second, now)
        self.jobs = _Allowance(limits.jobs_per_day, limits.jobs_per_day / DAY, now)
        self.cases = _Allowance(limits.cases_per_day, limits.cases_per_day / DAY, now)
        self.bytes = _Allowance(limits.body_bytes_per_day, limits.body_bytes_per_day / DAY, now)


class Quotas:
    """Counts what principals use; every method may be called from any thread."""

    def __init__(self, limits: QuotaLimits, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._limits, self._clock = limits, clock
        self._lock = threading.Lock()
        self._accounts: dict[str, _Account] = {}
        # apart from the tokens' own: whoever comes from many addresses must not push a token's count out
        self._strangers: OrderedDict[str, _Account] = OrderedDict()

    def admit(self, principal: Principal) -> None:
        """Count a request; raises `QuotaError` where requests or bytes are used up."""
        if not principal.limited:
            return
        with self._lock:
            self._admit(self._account(principal), f"the token '{principal.name}'")

    def admit_stranger(self, address: str) -> None:
        """Count a request with a wrong token, or none, from an address; raises `QuotaError` where they are too many."""
        with self._lock:
            account = self._strangers.pop(address, None) or _Account(self._limits, self._clock())
            self._strangers[address] = account
            if len(self._strangers) > MOST_STRANGERS:
                self._strangers.popitem(last=False)
            self._admit(account, "this address")

    def spend_bytes(self, principal: Principal, count: int) -> None:
        """Count the bytes of a body that was read; the next request waits where they were too many."""
        if principal.limited and count > 0:
            with self._lock:
                self._account(principal).bytes.take(count)

    def check_job(self, principal: Principal, ends: Sequence[float | None], *, cases: int) -> None:
        """Count a new job of so many cases; `ends` are as in `check_running`.

        Raises
        ------
        QuotaError
            Where the job is too large for any day, or has to wait. Nothing is counted then.

        """
        if not principal.limited:
            return
        limits = self._limits
        with self._lock:
            account, now = self._account(principal), self._clock()
            whose = f"the token '{principal.name}'"
            if not account.cases.never(cases):  # where no waiting helps, nothing else need be told
                self.check_running(principal, ends)
                _demand(account.jobs, 1, now, f"{whose} has used up its {limits.jobs_per_day} jobs a day",
                        limit="quota_jobs_per_day")  # fmt: skip
            _demand(account.cases, cases, now, f"a job of {cases} cases exceeds what is left to {whose} of its "
                    f"{limits.cases_per_day} cases a day", limit="quota_cases_per_day")  # fmt: skip
            account.jobs.take(1)
            account.cases.take(cases)

    def check_running(self, principal: Principal, ends: Sequence[float | None]) -> None:
        """Raise `QuotaError` where one more job may not be under way beside the unfinished ones; nothing counts.

        `ends` holds for each of these the seconds after which it will end, None where that is not known.
        """
        most = self._limits.running_jobs
        if principal.limited and 0 < most <= len(ends):
            known = sorted(end for end in ends if end is not None)
            surplus = len(ends) - most  # so many must end before the one whose end makes room
            wait = known[surplus] if surplus < len(known) else UNKNOWN_END
            raise QuotaError(
                f"{len(ends)} jobs of the token '{principal.name}' are unfinished, and {most} may be: "
                "wait for one to end, or cancel one",
                limit="quota_running_jobs", bound=most, retry_after=min(wait, LONGEST_WAIT),
            )  # fmt: skip

    def _account(self, principal: Principal) -> _Account:
        account = self._accounts.get(principal.name)
        if account is None:
            account = self._accounts[principal.name] = _Account(self._limits, self._clock())
        return account

    def _admit(self, account: _Account, whose: str) -> None:
        limits, now = self._limits, self._clock()
        _demand(account.bytes, 1, now, f"{whose} has sent its {limits.body_bytes_per_day} bytes a day",
                limit="quota_body_bytes_per_day")  # fmt: skip
        _demand(account.requests, 1, now, f"{whose} sends more than {limits.requests_per_second:g} requests a second",
                limit="quota_requests_per_second")  # fmt: skip
        account.requests.take(1)


def _demand(allowance: _Allowance, amount: float, now: float, complaint: str, *, limit: str) -> None:
    wait = allowance.wait(amount, now)
    if wait == 0.0:
        return
    never = math.isinf(wait)
    way_out = "split it, or ask for a larger quota" if never else f"try again in {math.ceil(wait)} s"
    raise QuotaError(f"{complaint}: {way_out}", limit=limit, bound=allowance.size, retry_after=None if never else wait)
