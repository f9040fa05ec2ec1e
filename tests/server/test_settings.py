"""The settings: where they come from, and which are refused."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from models.limits import DEFAULT_LIMITS
from server.settings import Settings, is_loopback

TOKEN = "a-token-of-some-length"


@pytest.fixture(autouse=True)
def no_settings_from_outside(monkeypatch):
    for name in Settings.model_fields:
        monkeypatch.delenv(f"GLIDER_STUDIO_{name.upper()}", raising=False)


def test_defaults_stay_on_this_machine():
    settings = Settings()
    assert (settings.host, settings.port, settings.token) == ("127.0.0.1", 8000, None)
    assert not settings.demands_token
    assert settings.limits == DEFAULT_LIMITS


def test_environment_is_read(monkeypatch):
    monkeypatch.setenv("GLIDER_STUDIO_PORT", "8123")
    monkeypatch.setenv("GLIDER_STUDIO_MAX_COMPONENTS", "7")
    monkeypatch.setenv("GLIDER_STUDIO_TOKEN", "")
    settings = Settings()
    assert (settings.port, settings.limits.components, settings.token) == (8123, 7, None)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.8.8", "::1", "[::1]", "localhost"])
def test_loopback_addresses_need_no_token(host):
    assert is_loopback(host)
    assert not Settings(host=host).demands_token


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.7", "glider.example", "localhost.example"])
def test_other_addresses_need_a_token(host):
    with pytest.raises(
        ValidationError, match=f"GLIDER_STUDIO_HOST={host} lets other machines in.*set GLIDER_STUDIO_TO"
    ):
        Settings(host=host)
    assert Settings(host=host, token=TOKEN).demands_token


@pytest.mark.parametrize("token", ["short", "with a space in its middle", "ümlaute-im-token-hier"])
def test_weak_tokens_are_refused_and_not_repeated(token):
    with pytest.raises(ValidationError, match="at least 16 printable ASCII") as caught:
        Settings(host="0.0.0.0", token=token)
    assert token not in str(caught.value)


def test_several_tokens_have_names():
    settings = Settings(host="0.0.0.0", token="anna:the-token-of-anna-1, the-token-of-bert-2")
    assert [(token.name, token.secret) for token in settings.tokens] == [
        ("anna", "the-token-of-anna-1"),
        ("token-2", "the-token-of-bert-2"),
    ]
    assert "the-token" not in repr(settings.tokens) + repr(settings)


@pytest.mark.parametrize(
    ("tokens", "says"),
    [
        ("anna:short,bert:the-token-of-bert-2", "at least 16 printable ASCII"),
        (f"{TOKEN},", "at least 16 printable ASCII"),
        (f"anna:{TOKEN},anna:{TOKEN}x", "same name twice"),
        (f"anna:{TOKEN},bert:{TOKEN}", "same token twice"),
    ],
)
@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_tokens_that_tell_users_badly_apart_are_refused_everywhere(host, tokens, says):
    with pytest.raises(ValidationError, match=says) as caught:
        Settings(host=host, token=tokens)
    assert TOKEN not in str(caught.value)


def test_lists_are_separated_by_commas(monkeypatch):
    monkeypatch.setenv("GLIDER_STUDIO_ALLOWED_HOSTS", "glider.example, 10.0.0.7")
    monkeypatch.setenv("GLIDER_STUDIO_CORS_ORIGINS", "https://lab.example,http://localhost:3000")
    settings = Settings()
    assert settings.allowed_hosts == ("glider.example", "10.0.0.7")
    assert settings.cors_origins == ("https://lab.example", "http://localhost:3000")


@pytest.mark.parametrize("origin", ["*", "lab.example", "https://lab.example/", "https://*.example", "null"])
def test_only_whole_origins_are_let_in(origin):
    with pytest.raises(ValidationError, match=r"GLIDER_STUDIO_CORS_ORIGINS.*is no origin"):
        Settings(cors_origins=origin)


@pytest.mark.parametrize("host", ["https://glider.example", "glider.example:443", "*.example", "a b"])
def test_only_bare_names_are_allowed_hosts(host):
    with pytest.raises(ValidationError, match=r"GLIDER_STUDIO_ALLOWED_HOSTS.*without scheme and port"):
        Settings(allowed_hosts=host)


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("port", "http", "a whole number from 0 to 65535 is wanted, not 'http'; unset it for 8000"),
        ("port", "65536", "a whole number from 0 to 65535 is wanted, not '65536'; unset it for 8000"),
        ("workers", "0", "a whole number from 1 to 1024 is wanted, not '0'; unset it"),
        ("max_cases", "1.5", "a whole number from 1 to 2147483647 is wanted, not '1.5'; unset it for 10000000"),
        ("max_duration", "-1", "a number above 0 is wanted, not '-1'; unset it for 604800.0"),
        ("preview_seconds", "nan", "a number above 0 and of at most 60 is wanted, not 'nan'; unset it for 1.5"),
        ("metrics_open", "perhaps", "true or false is wanted, not 'perhaps'; unset it for false"),
        ("log_level", "inof", "'debug', 'info', 'warning' or 'error' is wanted, not 'inof'; did you mean info?"),
        ("scheduler", "localhost:8786", "'localhost:8786' does not have the form ^(tcp|tls|ws|wss)://.; "
         "give address of a Dask scheduler for jobs, as tcp://host:8786; else a pool of processes"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_told_in_plain_words(monkeypatch, name, value, says):
    monkeypatch.setenv(f"GLIDER_STUDIO_{name.upper()}", value)
    with pytest.raises(ValidationError) as caught:
        Settings()
    (told,) = caught.value.errors()
    assert (told["loc"], told["msg"]) == ((name,), says)


def test_every_wrong_value_is_told_at_once(monkeypatch):
    monkeypatch.setenv("GLIDER_STUDIO_PORT", "x")
    monkeypatch.setenv("GLIDER_STUDIO_LOG_FORMAT", "xml")
    with pytest.raises(ValidationError) as caught:
        Settings()
    assert [item["loc"] for item in caught.value.errors()] == [("port",), ("log_format",)]


def test_an_address_that_may_hold_a_password_is_not_repeated(monkeypatch):
    monkeypatch.setenv("GLIDER_STUDIO_DATABASE_URL", "mysql://anna:her-password@lab.example/designs")
    with pytest.raises(ValidationError, match=r"what is given does not have the form .*; give sqlite:///") as got:
        Settings()
    assert "her-password" not in str(got.value)
    assert "her-password" not in "".join(item["msg"] for item in got.value.errors())
