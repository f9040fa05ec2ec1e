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
