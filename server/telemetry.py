"""Owns the figures that Prometheus collects of one application. It knows no HTTP.

Every application has a registry of its own. Whoever has figures of its own registers a collector there:
`telemetry.registry.register(collector)`, or makes its metrics with `registry=telemetry.registry`.
"""

from __future__ import annotations

from collections.abc import Callable

from prometheus_client import CollectorRegistry, Gauge, Histogram, Info, PlatformCollector, ProcessCollector
from prometheus_client.exposition import choose_encoder

from server.version import VERSION

METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
SECONDS = (0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
"""Upper edges of the histogram; a preview takes from a few milliseconds to its limit of seconds."""


class Telemetry:
    """Counts requests by the template of their address, so that the number of series is bounded."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        PlatformCollector(registry=self.registry)
        Info("glider_studio_build", "The program.", registry=self.registry).info({"version": VERSION})
        self._requests = Histogram(
            "glider_studio_request_seconds", "Requests answered, and the time each took.",
            ("method", "route", "status"), buckets=SECONDS, registry=self.registry,
        )  # fmt: skip
        self.in_progress = Gauge(
            "glider_studio_requests_in_progress", "Requests under way, open event streams among them.",
            registry=self.registry,
        )  # fmt: skip

    def observe(self, method: str, route: str, *, status: int, seconds: float) -> None:
        """Count an answered request."""
        method = method if method in METHODS else "other"
        self._requests.labels(method, route, status).observe(seconds)

    def watch(self, name: str, words: str, value: Callable[[], float]) -> None:
        """Add a gauge whose value is asked for when figures are collected."""
        Gauge(f"glider_studio_{name}", words, registry=self.registry).set_function(value)

    def exposition(self, accept: str) -> tuple[bytes, str]:
        """Return all figures and their media type, in the form that an Accept header asks for."""
        encode, media_type = choose_encoder(accept)
        return encode(self.registry), media_type
