"""Owns the settings: environment variables that begin with GLIDER_STUDIO_, checked once at the start."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self
from urllib.parse import urlsplit

from platformdirs import user_data_dir
from pydantic import BeforeValidator, Field, ModelWrapValidatorHandler, SecretStr, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from models.limits import DEFAULT_LIMITS, Limits
from models.plain_words import value_problem
from models.problems import echo
from models.suggestions import suggestion
from server.quotas import QuotaLimits
from server.tokens import NamedToken, read_tokens

PREFIX = "GLIDER_STUDIO_"
ELSEWHERE = ("KERNEL_CACHE",)
"""What is read from the environment before there are settings."""
HOST_NAME = re.compile(r"[A-Za-z0-9.-]{1,253}|\[?[0-9A-Fa-f:.]+\]?")


def _listed(value: Any) -> Any:
    return tuple(item.strip() for item in value.split(",") if item.strip()) if isinstance(value, str) else value


Listed = Annotated[tuple[str, ...], NoDecode, BeforeValidator(_listed)]
"""Several words, separated by commas in an environment variable."""


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
        env_prefix=PREFIX, env_ignore_empty=True, hide_input_in_errors=True, extra="ignore", frozen=True
    )

    host: str = Field(default="127.0.0.1", min_length=1, description="Address to listen on.")
    port: int = Field(default=8000, ge=0, le=65_535, description="Port to listen on; 0 takes a free one.")
    data: Path = Field(default=Path(user_data_dir("glider-studio")), description="Folder for the program's data.")
    database_url: str | None = Field(
        default=None, repr=False, pattern=r"^(sqlite:///.|postgres(ql)?(\+psycopg)?://.)",
        description="sqlite:///FILE or postgresql://USER:PASSWORD@HOST/NAME; a file in the data folder if not given.",
    )  # fmt: skip
    scheduler: str | None = Field(
        default=None, pattern=r"^(tcp|tls|ws|wss)://.",
        description="Address of a Dask scheduler for jobs, as tcp://host:8786; else a pool of processes.",
    )  # fmt: skip
    workers: int | None = Field(
        default=None, ge=1, le=1024, description="Processes of the pool; one a core if not given."
    )
    max_cases: int = Field(default=10_000_000, ge=1, le=2**31 - 1, description="Most cases of a job.")
    min_free_mib: int = Field(default=256, ge=0, description="Jobs pause while less is free where results go, MiB.")
    token: SecretStr | None = Field(
        default=None, repr=False,
        description="Demanded of every request to the API; several as name:token, separated by commas.",
    )  # fmt: skip
    allowed_hosts: Listed = Field(default=(), description="Names under which a proxy serves the program.")
    cors_origins: Listed = Field(default=(), description="Other sites whose scripts may use the API.")
    metrics_open: bool = Field(default=False, description="Whether /metrics is answered without a token.")
    log_format: Literal["text", "json"] = Field(default="text", description="How log lines are written.")
    log_level: Literal["debug", "info", "warning", "error"] = Field(default="info", description="Least level logged.")

    quota_requests_per_second: float = Field(default=50.0, ge=0.0, description="Requests of a token; 0: any number.")
    quota_burst: int = Field(default=200, ge=1, description="Requests of a token at once, after a rest.")
    quota_running_jobs: int = Field(default=4, ge=0, description="Unfinished jobs of a token; 0: any number.")
    quota_jobs_per_day: int = Field(default=1000, ge=0, description="Jobs of a token in a day; 0: any number.")
    quota_cases_per_day: int = Field(default=10_000_000, ge=0, description="Cases of a token in a day; 0: any number.")
    quota_body_bytes_per_day: int = Field(default=10 * 2**30, ge=0, description="Bytes a token sends in a day; 0: any.")

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

    @model_validator(mode="wrap")
    @classmethod
    def _refused_in_plain_words(cls, given: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(given)
        except ValidationError as error:
            # the schema is made where it is needed: in a start that fails
            fields = cls.model_json_schema()["properties"]
            lines = [_in_plain_words(item, fields) for item in error.errors(include_url=False)]
            raise ValidationError.from_exception_data(cls.__name__, lines, hide_input=True) from None

    @model_validator(mode="after")
    def _other_machines_need_a_token(self) -> Self:
        tokens = self.tokens  # read here, so that a weak one is told at the start wherever the program listens
        if not tokens and not is_loopback(self.host):
            raise ValueError(
                f"GLIDER_STUDIO_HOST={self.host} lets other machines in, which needs a token: "
                "set GLIDER_STUDIO_TOKEN, or listen on 127.0.0.1"
            )
        return self

    @model_validator(mode="after")
    def _names_and_origins_are_such(self) -> Self:
        for name in self.allowed_hosts:
            if HOST_NAME.fullmatch(name) is None:
                raise ValueError(
                    f"GLIDER_STUDIO_ALLOWED_HOSTS: '{name}' is no host name; give it without scheme and port"
                )
        for origin in self.cors_origins:
            parts = urlsplit(origin)
            if parts.scheme not in ("http", "https") or origin != f"{parts.scheme}://{parts.netloc}" or "*" in origin:
                raise ValueError(
                    f"GLIDER_STUDIO_CORS_ORIGINS: '{origin}' is no origin; write each as https://name or https://name:port"
                )
        return self

    @property
    def tokens(self) -> tuple[NamedToken, ...]:
        """The tokens that open the API."""
        text = self.token.get_secret_value() if self.token is not None else ""
        return read_tokens(text) if text else ()

    @property
    def demands_token(self) -> bool:
        """Whether requests to the API must carry a token: wherever one is set, and so on any address but loopback."""
        return bool(self.tokens)

    @property
    def quotas(self) -> QuotaLimits:
        """What each token may use."""
        return QuotaLimits(
            requests_per_second=self.quota_requests_per_second,
            burst=self.quota_burst,
            running_jobs=self.quota_running_jobs,
            jobs_per_day=self.quota_jobs_per_day,
            cases_per_day=self.quota_cases_per_day,
            body_bytes_per_day=self.quota_body_bytes_per_day,
        )

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


def _in_plain_words(item: Any, fields: dict[str, Any]) -> InitErrorDetails:
    """Return one of pydantic's errors, told as a person would; what may be secret is not repeated."""
    details = InitErrorDetails(type=item["type"], loc=item["loc"], input=item["input"], ctx=item.get("ctx", {}))
    if not item["loc"] or item["type"] == "value_error":  # in words of our own already
        return details
    name = item["loc"][0]
    info = Settings.model_fields[name]
    shown = echo(item["input"]) if info.repr else "what is given"
    otherwise = f"unset it for {echo(info.default)}" if info.default is not None else "unset it"
    told = value_problem(item, fields[name], shown=shown, otherwise=otherwise)
    details["type"] = PydanticCustomError(item["type"], "{told}", {"told": f"{told.message}; {told.hint}"})
    return details


def unknown_settings(environment: Iterable[str]) -> Iterator[str]:
    """Yield a warning for each variable whose name looks like a setting and is none: nothing would read it."""
    known = [name.upper() for name in (*Settings.model_fields, *ELSEWHERE)]
    for name in sorted(environment):
        own = name.upper().removeprefix(PREFIX)
        if name.upper() != own and own not in known:
            yield f"{name} is no setting, and nothing reads it: {suggestion(own, known, prefix=PREFIX) or 'unset it'}"
