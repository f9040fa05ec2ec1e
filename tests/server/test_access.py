"""Who may use the API: the token where one is set, our own host name, no other site, safe headers."""

from __future__ import annotations

import secrets

import pytest
from fastapi import Response

from server.app import create_app
from server.settings import Settings
from tests.server.support import APP, PREVIEW, VALIDATE, ask, assert_problem, local_app, preset

TOKEN = "a-token-of-some-length"
ANNA, BERT = "the-token-of-anna-1", "the-token-of-bert-2"
GUARDED = create_app(Settings(host="0.0.0.0", token=TOKEN))
PRESETS = "/api/v1/presets"
SITE = "https://lab.example"


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


@pytest.mark.parametrize("given", [None, "", TOKEN, f"Basic {TOKEN}", "Bearer", f"Bearer {TOKEN}x", "Bearer é"])
def test_without_the_token_nothing_is_answered(given):
    headers = {} if given is None else {"authorization": given.encode("latin-1")}
    answer = ask("GET", PRESETS, app=GUARDED, headers=headers)
    assert_problem(answer, 401, says="Authorization: Bearer")
    assert answer.headers["www-authenticate"] == "Bearer"


@pytest.mark.parametrize(
    "path", ["/api/v1/openapi.json", "/api/v1/nothing", "/api/v1/simulations:preview", "/%61pi/v1/presets", "/metrics"]
)
def test_whatever_lies_under_the_api_is_guarded(path):
    assert_problem(ask("GET", path, app=GUARDED), 401)


@pytest.mark.parametrize("scheme", ["Bearer", "bearer"])
def test_with_the_token_everything_is_answered(scheme):
    answer = ask("GET", PRESETS, app=GUARDED, headers={"authorization": f"{scheme} {TOKEN}"})
    assert answer.status_code == 200


def test_health_and_loopback_need_no_token():
    assert ask("GET", "/healthz", app=GUARDED).status_code == 200
    assert ask("GET", "/readyz", app=GUARDED).status_code == 200
    assert ask("GET", PRESETS, app=APP).status_code == 200


def test_a_token_is_demanded_on_loopback_too_where_one_is_set():
    """Behind a proxy the program listens on loopback, and the proxy brings everybody."""
    app = create_app(Settings(host="127.0.0.1", token=TOKEN))
    assert_problem(ask("GET", PRESETS, app=app), 401)
    assert ask("GET", PRESETS, app=app, headers=bearer(TOKEN)).status_code == 200


def test_the_document_says_who_needs_the_token():
    headers = {"authorization": f"Bearer {TOKEN}"}
    assert ask("GET", "/api/v1/openapi.json", app=GUARDED, headers=headers).json()["security"] == [{"token": []}]
    assert "security" not in ask("GET", "/api/v1/openapi.json").json()


@pytest.mark.parametrize("given", [TOKEN, ANNA, BERT, "x", ""])
def test_every_token_is_compared_whole_whichever_is_right(given, monkeypatch):
    app = create_app(Settings(host="0.0.0.0", token=f"anna:{ANNA},bert:{BERT}"))
    compared = []
    original = secrets.compare_digest

    def remember(a, b):
        compared.append((len(a), len(b)))
        return original(a, b)

    monkeypatch.setattr(secrets, "compare_digest", remember)
    assert ask("GET", PRESETS, app=app, headers=bearer(given)).status_code == (200 if given in (ANNA, BERT) else 401)
    # header and cookie with each of two tokens, as digests of one length
    assert compared == [(32, 32)] * 4


def test_whoever_brings_a_wrong_token_again_and_again_is_slowed_down_and_the_right_one_is_not():
    app = create_app(Settings(host="0.0.0.0", token=TOKEN, quota_burst=5, quota_requests_per_second=0.01))
    statuses = [ask("GET", PRESETS, app=app, headers=bearer("wrong")).status_code for _ in range(7)]
    assert statuses == [401] * 5 + [429] * 2
    assert ask("GET", PRESETS, app=app, headers=bearer(TOKEN)).status_code == 200


def test_each_token_has_its_own_requests_and_429_says_when_to_come_again():
    settings = Settings(host="0.0.0.0", token=f"anna:{ANNA},bert:{BERT}", quota_burst=3, quota_requests_per_second=0.01)
    app = create_app(settings)
    assert [ask("GET", PRESETS, app=app, headers=bearer(ANNA)).status_code for _ in range(4)] == [200] * 3 + [429]
    refused = ask("GET", PRESETS, app=app, headers=bearer(ANNA))
    assert_problem(refused, 429, says="GLIDER_STUDIO_QUOTA_REQUESTS_PER_SECOND")
    assert 90 <= int(refused.headers["retry-after"]) <= 100
    assert "anna" in refused.json()["detail"] and ANNA not in refused.text
    assert ask("GET", PRESETS, app=app, headers=bearer(BERT)).status_code == 200


def test_bytes_that_were_sent_are_counted():
    app = create_app(Settings(host="0.0.0.0", token=TOKEN, quota_body_bytes_per_day=1000))
    assert ask("POST", VALIDATE, preset(), app=app, headers=bearer(TOKEN)).status_code == 200
    refused = ask("GET", PRESETS, app=app, headers=bearer(TOKEN))
    assert_problem(refused, 429, says="1000 bytes a day")
    assert int(refused.headers["retry-after"]) > 3600


def test_a_body_that_never_fits_is_told_before_a_quota_that_refills():
    app = create_app(Settings(host="0.0.0.0", token=TOKEN, quota_burst=1, quota_requests_per_second=0.001))
    assert ask("GET", PRESETS, app=app, headers=bearer(TOKEN)).status_code == 200
    assert_problem(ask("POST", VALIDATE, preset(), app=app, headers=bearer(TOKEN)), 429)
    too_large = b" " * 5_000_000
    assert_problem(ask("POST", VALIDATE, too_large, app=app, headers=bearer(TOKEN)), 413, says="limit of 4194304 bytes")
    assert_problem(ask("POST", VALIDATE, too_large, app=app), 401)  # a stranger learns nothing


def test_without_tokens_nothing_is_counted():
    app = local_app(quota_burst=1, quota_requests_per_second=0.001, quota_body_bytes_per_day=1)
    assert {ask("POST", VALIDATE, preset(), app=app).status_code for _ in range(5)} == {200}


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "localhost.evil", ""])
def test_on_loopback_a_foreign_host_name_is_refused(host):
    """A page whose name was rebound to 127.0.0.1 is of the same origin to a browser; only its name gives it away."""
    for method, path in (("GET", PRESETS), ("POST", PREVIEW), ("GET", "/metrics"), ("GET", "/")):
        problem = assert_problem(ask(method, path, headers={"host": host}), 421)
        assert "GLIDER_STUDIO_ALLOWED_HOSTS" in problem["detail"]
    assert ask("GET", "/healthz", headers={"host": host}).status_code == 200


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST:8000", "127.0.0.1:8000", "[::1]:8000", "127.0.0.2"])
def test_this_machines_own_names_are_known(host):
    assert ask("GET", PRESETS, headers={"host": host}).status_code == 200


def test_a_proxys_name_is_known_once_it_is_allowed():
    app = local_app(allowed_hosts=("glider.example",))
    assert ask("GET", PRESETS, app=app, headers={"host": "Glider.example:443"}).status_code == 200
    assert ask("GET", PRESETS, app=app, headers={"host": "other.example"}).status_code == 421


def test_elsewhere_any_name_will_do_unless_some_are_allowed():
    given = bearer(TOKEN) | {"host": "any.example"}
    assert ask("GET", PRESETS, app=GUARDED, headers=given).status_code == 200
    strict = create_app(Settings(host="0.0.0.0", token=TOKEN, allowed_hosts="glider.example"))
    assert ask("GET", PRESETS, app=strict, headers=given).status_code == 421
    assert ask("GET", PRESETS, app=strict, headers=given | {"host": "glider.example"}).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [{"origin": "http://evil.example"}, {"origin": "null"}, {"origin": "http://["}, {"sec-fetch-site": "cross-site"}],
)
def test_other_sites_change_nothing(headers):
    assert_problem(ask("POST", VALIDATE, preset(), headers=headers), 403, says="GLIDER_STUDIO_CORS_ORIGINS")
    assert ask("GET", PRESETS, headers=headers).status_code == 200
    assert ask("POST", VALIDATE, preset(), headers={"origin": "http://localhost"}).status_code == 200


PREFLIGHT = {"origin": SITE, "access-control-request-method": "POST", "access-control-request-headers": "content-type"}


def test_cors_is_closed():
    for app in (APP, GUARDED):
        for answer in (
            ask("OPTIONS", VALIDATE, app=app, headers=PREFLIGHT), ask("GET", PRESETS, app=app, headers=PREFLIGHT),
        ):  # fmt: skip
            assert not [name for name in answer.headers if name.startswith("access-control-")]
    assert_problem(ask("OPTIONS", VALIDATE, headers=PREFLIGHT), 405)
    assert_problem(ask("OPTIONS", VALIDATE, app=GUARDED, headers=PREFLIGHT), 401)


def test_cors_opens_to_named_sites_only():
    app = create_app(Settings(host="0.0.0.0", token=TOKEN, cors_origins=f"{SITE},http://localhost:3000"))
    allowed = ask("OPTIONS", VALIDATE, app=app, headers=PREFLIGHT)
    assert allowed.status_code == 200
    assert allowed.headers["access-control-allow-origin"] == SITE
    assert "Idempotency-Key" in allowed.headers["access-control-allow-headers"]
    assert "access-control-allow-credentials" not in allowed.headers
    answer = ask("POST", VALIDATE, preset(), app=app, headers=bearer(TOKEN) | {"origin": SITE})
    assert (answer.status_code, answer.headers["access-control-allow-origin"]) == (200, SITE)
    foreign = {"origin": "https://evil.example"}
    assert "access-control-allow-origin" not in ask("OPTIONS", VALIDATE, app=app, headers=PREFLIGHT | foreign).headers
    assert ask("POST", VALIDATE, preset(), app=app, headers=bearer(TOKEN) | foreign).status_code == 403


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [("GET", PRESETS, 200), ("GET", "/healthz", 200), ("GET", "/metrics", 200), ("GET", "/api/v1/no", 404),
     ("DELETE", PRESETS, 405), ("POST", VALIDATE, 415), ("GET", "/crash", 500)],
)  # fmt: skip
def test_every_answer_has_the_safe_headers(method, path, status):
    app = local_app()

    @app.get("/api/v1/crash")
    def crash() -> None:
        raise RuntimeError("a secret")

    answer = ask(method, path.replace("/crash", "/api/v1/crash"), app=app)
    assert answer.status_code == status
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert answer.headers["x-frame-options"] == "DENY"
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["content-security-policy"].startswith("default-src 'none'")
    assert answer.headers["x-request-id"]
    assert len(answer.headers) == len(set(answer.headers)), "no header twice"


def test_an_answers_own_headers_stand_and_an_etag_may_be_kept():
    app = local_app()

    @app.get("/api/v1/own")
    def own(response: Response) -> int:
        response.headers["Content-Security-Policy"] = "sandbox"
        response.headers["ETag"] = '"1"'
        return 1

    answer = ask("GET", "/api/v1/own", app=app)
    assert answer.headers.get_list("content-security-policy") == ["sandbox"]
    assert answer.headers["cache-control"] == "private, no-cache"
