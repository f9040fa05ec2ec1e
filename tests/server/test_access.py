"""The token: demanded on any address but loopback, and only there."""

from __future__ import annotations

import pytest

from server.app import create_app
from server.settings import Settings
from tests.server.support import APP, ask, assert_problem

TOKEN = "a-token-of-some-length"
GUARDED = create_app(Settings(host="0.0.0.0", token=TOKEN))


@pytest.mark.parametrize("given", [None, "", TOKEN, f"Basic {TOKEN}", "Bearer", f"Bearer {TOKEN}x", "Bearer é"])
def test_without_the_token_nothing_is_answered(given):
    headers = {} if given is None else {"authorization": given.encode("latin-1")}
    answer = ask("GET", "/api/v1/presets", app=GUARDED, headers=headers)
    assert_problem(answer, 401, says="Authorization: Bearer")
    assert answer.headers["www-authenticate"] == "Bearer"


@pytest.mark.parametrize("path", ["/api/v1/openapi.json", "/api/v1/nothing", "/api/v1/simulations:preview"])
def test_whatever_lies_under_the_api_is_guarded(path):
    assert_problem(ask("GET", path, app=GUARDED), 401)


@pytest.mark.parametrize("scheme", ["Bearer", "bearer"])
def test_with_the_token_everything_is_answered(scheme):
    answer = ask("GET", "/api/v1/presets", app=GUARDED, headers={"authorization": f"{scheme} {TOKEN}"})
    assert answer.status_code == 200


def test_health_and_loopback_need_no_token():
    assert ask("GET", "/healthz", app=GUARDED).status_code == 200
    assert ask("GET", "/api/v1/presets", app=APP).status_code == 200


def test_the_document_says_who_needs_the_token():
    headers = {"authorization": f"Bearer {TOKEN}"}
    assert ask("GET", "/api/v1/openapi.json", app=GUARDED, headers=headers).json()["security"] == [{"token": []}]
    assert "security" not in ask("GET", "/api/v1/openapi.json").json()
