"""Owns the figures of jobs that Prometheus collects: those of the database, of this process, and of who computes."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from server.jobs.service import Jobs
from server.store.errors import StoreError

PREFIX = "glider_studio_job"


class JobFigures(Collector):
    """Asks when figures are collected: the database once, a cluster never."""

    def __init__(self, jobs: Jobs) -> None:
        self._jobs = jobs

    def collect(self) -> Iterator[Metric]:
        """Yield the figures; where the database does not answer its own are left out."""
        manager = self._jobs.manager
        try:
            yield self._states()
        except StoreError:
            pass  # the log says why, and /readyz that
        yield CounterMetricFamily(
            f"{PREFIX}_cases", "Cases counted by this process, failed ones among them.", value=manager.cases_done
        )
        yield CounterMetricFamily(
            f"{PREFIX}_cases_failed", "Failed cases counted by this process.", value=manager.cases_failed
        )
        yield GaugeMetricFamily(
            f"{PREFIX}_chunks_in_flight", "Chunks that this process has sent to be computed.", value=manager.in_flight
        )
        workers = manager.engine.known_workers
        if workers is not None:
            yield GaugeMetricFamily(f"{PREFIX}_workers", "Chunks that can be computed at once.", value=workers)

    def _states(self) -> Metric:
        family = GaugeMetricFamily(f"{PREFIX}s", "Jobs in the database by state.", labels=["state"])
        for state, count in self._jobs.store.counts().items():
            family.add_metric([state], count)
        return family
