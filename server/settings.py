"""Owns the settings: environment variables that begin with GLIDER_STUDIO_, checked once at the start."""

from __future__ import annotations

import ipaddress
from pathlib import Path
from typing import Self

from platformdirs import user_data_dir
from pydantic import Field, SecretStr, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from models.limits import DEFAULT_LIMITS, Limits

LEAST_TOKEN = 16


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach a server bound to `host`."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host == "localhost"


class Settings(BaseSettings):
    """Where the program listens, where it keeps its data, and what it accepts.

    The limits of a preview lie below those of a run: a preview answers at once or says why not.
    """

    model_config = SettingsConfigDict(
        env_prefix="GLIDER_STUDIO_", env_ignore_empty=True, hide_input_in_errors=True, extra="ignore", frozen=True
    )

    host: str = Field(default="127.0.0.1", min_length=1, description="Address to listen on.")
    port: int = Field(default=8000, ge=0, le=65_535, description="Port to listen on; 0 takes a free one.")
    data: Path = Field(default=Path(user_data_dir("glider-studio")), description="Folder for the program's data.")
    token: SecretStr | None = Field(default=None, description="Demanded of every request from another machine.")

    max_body_bytes: int = Field(default=4 * 2**20, ge=1024, description="Largest body of a request.")
    max_body_values: int = Field(default=250_000, ge=1000, description="Most values in one JSON body.")
    max_components: int = Field(default=DEFAULT_LIMITS.components, ge=1, description="Most components of a vehicle.")
    max_schedule_points: int = Field(default=DEFAULT_LIMITS.schedule_points, ge=0, description="Most schedule points.")
    max_table_rows: int = Field(default=DEFAULT_LIMITS.table_rows, ge=4, description="Most rows of a force table.")
    max_duration: float = Field(default=DEFAULT_LIMITS.duration, gt=0.0, description="Longest mission, s.")
    max_samples: int = Field(default=DEFAULT_LIMITS.samples, ge=2, description="Most samples of a result.")
    max_steps: int = Field(default=DEFAULT_LIMITS.steps, ge=1, description="Most steps of the integrator.")
    preview_steps: int = Field(default=2_000_000, ge=1, description="Most steps of a preview.")
    preview_numbers: int = Field(default=4_000_000, ge=10_000, description="Most numbers in a preview's result.")
    preview_seconds: float = Field(default=1.5, gt=0.0, le=60.0, description="Longest a preview computes, s.")

    @model_validator(mode="after")
    def _other_machines_need_a_token(self) -> Self:
        secret = "" if self.token is None else self.token.get_secret_value()
        if self.demands_token and not secret:
            raise ValueError(
                f"GLIDER_STUDIO_HOST={self.host} lets other machines in, which needs a token: "
                "set GLIDER_STUDIO_TOKEN, or listen on 127.0.0.1"
            )
        if secret and (len(secret) < LEAST_TOKEN or not secret.isascii() or not secret.isprintable() or " " in secret):
            raise ValueError(
                f"GLIDER_STUDIO_TOKEN must be at least {LEAST_TOKEN} printable ASCII characters without spaces"
            )
        return self

    @property
    def demands_token(self) -> bool:
        """Whether requests to the API must carry the token: on any address but loopback."""
        return not is_loopback(self.host)

    @property
    def limits(self) -> Limits:
        """The limits of a run."""
        return Limits(
            components=self.max_components,
            schedule_points=self.max_schedule_points,
            table_rows=self.max_table_rows,
            duration=self.max_duration,
            samples=self.max_samples,
            steps=self.max_steps,
        )
