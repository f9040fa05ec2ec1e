"""Owns the settings of the property tests: repeatable, and without a clock (the first example compiles the kernel)."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "physics", deadline=None, derandomize=True, max_examples=25, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("physics")
