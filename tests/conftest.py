"""What holds for all tests."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# how fast inputs are made says how busy the machine is, nothing of the program
settings.register_profile("unhurried", suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("unhurried")
