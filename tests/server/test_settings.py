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
