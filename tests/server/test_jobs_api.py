"""The jobs as the API shows them: submitted once, listed, cancelled, gone on with, within quotas."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace

import pytest

from models.design import parse_design
from server.app import create_app
from server.jobs.spec import batch_schema
from server.schemas_jobs import JobPage, JobRecord
from server.settings import Settings
from server.store.records import Content
from tests.server.job_api_support import JOBS, NOBODY, Api, idle_api
from tests.server.job_support import POSITION, finished, glider, sweep
from tests.server.support import ask, assert_problem, read_json

TOKEN, OTHER = "the-token-of-anna-1", "the-token-of-bert-1"
DRAWN = {"pointer": POSITION, "distribution": {"kind": "uniform", "low": 0.1, "high": 0.2}}


# submitting


def test_a_job_is_accepted_watched_and_done(api):
    answer = api.ask("POST", "", sweep(3, name="Three"))
    assert answer.status_code == 202 and answer.headers["retry-after"] == "1"
    record = JobRecord.model_validate_json(answer.content)
    assert answer.headers["location"] == f"{JOBS}/{record.id}"
    finished(api.jobs, api.jobs.store.get(record.id))
    record = JobRecord.model_validate(api.get(f"/{record.id}"), strict=False)
    assert record.state == "succeeded" and record.over and record.progress.done == 3
    assert record.name == "Three" and record.kind == "sweep"


def test_a_key_submits_once(idle):
    first = idle.ask("POST", "", sweep(), headers={"Idempotency-Key": "monday"})
    again = idle.ask("POST", "?fresh=true", sweep(), headers={"Idempotency-Key": "monday"})
    assert first.json() == again.json() and again.status_code == 202
    assert "idempotent-replayed" not in first.headers and again.headers["idempotent-replayed"] == "true"
    other = idle.ask("POST", "", sweep(13), headers={"Idempotency-Key": "monday"})
    assert_problem(other, 422, says="Idempotency-Key")
    assert len(idle.get("")["items"]) == 1


@pytest.mark.parametrize("key", ["", "x" * 256, "two words", "é".encode("latin-1")])
def test_odd_keys_are_refused(idle, key):
    assert_problem(idle.ask("POST", "", sweep(), headers={"Idempotency-Key": key}), 422, says="Idempotency-Key")


def test_equal_jobs_are_one_unless_fresh(idle):
    first, equal = (idle.ask("POST", "", sweep(name=name)).json() for name in ("a", "b"))
    fresh = idle.ask("POST", "?fresh=true", sweep()).json()
    assert equal == first and fresh["id"] != first["id"] and fresh["checksum"] == first["checksum"]


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"kind": "sweeep"}, "/kind"),
        ({"metrics": ["range", "speed of light"]}, "/metrics/1"),
        ({"trajectories": [99]}, "/trajectories/0"),
        ({"design_id": "x"}, ""),
        ({"version": 2}, "/version"),
        ({"method": {"kind": "cases", "parameters": [{"pointer": "/nowhere"}], "rows": [[1]]}}, None),
    ],
)
def test_what_is_wrong_is_pointed_at_and_nothing_is_kept(idle, change, pointer):
    problem = assert_problem(idle.ask("POST", "", sweep() | change), 422)
    assert pointer is None or pointer in [item["pointer"] for item in problem["errors"]], problem
    assert idle.get("")["items"] == []


def test_too_many_cases_are_refused_with_the_bound(idle):
    problem = assert_problem(idle.ask("POST", "", sweep(1001)), 422, says="1001")
    assert problem["errors"][0]["limit"] == 1000


def test_bodies_are_json(idle):
    assert_problem(idle.ask("POST", "", b"{"), 400)
    assert_problem(idle.ask("POST", "", b"{}", headers={"content-type": "text/plain"}), 415)
    assert_problem(idle.ask("POST", "", b"x" * 5_000_000), 413)


def test_a_stored_design_is_found_at_its_revision(idle):
    stored = idle.designs.create(Content(parse_design(glider())))
    document = {name: value for name, value in sweep(4).items() if name != "design"}
    record = idle.ask("POST", "", document | {"design_id": stored.id}).json()
    assert record["design"] == {"name": stored.design.name, "identity": stored.identity, "id": stored.id, "revision": 1}
    wrong = idle.ask("POST", "", document | {"design_id": stored.id, "revision": 9})
    problem = assert_problem(wrong, 422, pointer="/revision", says="newest is 1")
    assert_leads_on(idle, problem, f"/api/v1/designs/{stored.id}/revisions")
    problem = assert_problem(idle.ask("POST", "", document | {"design_id": NOBODY}), 422, pointer="/design_id")
    assert_leads_on(idle, problem, "/api/v1/designs")


def assert_leads_on(idle, problem, address):
    """The hint names an address as it is asked for."""
    assert problem["errors"][0]["hint"] == f"GET {address} lists those there are"
    assert ask("GET", address, app=idle.app).status_code == 200


def test_a_row_of_a_wrong_length_is_pointed_at_where_it_ends(idle):
    method = {"kind": "cases", "parameters": [{"pointer": POSITION}], "rows": [[0.1], [], [0.2, 0.3]]}
    problem = assert_problem(idle.ask("POST", "", sweep() | {"method": method}), 422)
    assert [(item["pointer"], item["message"], item["limit"]) for item in problem["errors"]] == [
        ("/method/rows/1/0", "row 2 has 0 values for 1 parameters: give one for each", 1),
        ("/method/rows/2/1", "row 3 has 2 values for 1 parameters: give one for each", 1),
    ]


@pytest.mark.parametrize(
    ("document", "name"),
    [
        ({"kind": "monte_carlo", "count": 4, "parameters": [DRAWN]}, "Monte Carlo of {}"),
        ({"kind": "simulate"}, "Simulation of {}"),
    ],
)
def test_a_job_without_a_name_is_called_by_its_kind_and_design(idle, document, name):
    design = glider()
    record = read_json(idle.ask("POST", "", {"format": "glider-batch", "version": 1, "design": design} | document))
    assert record["name"] == name.format(design["name"])


@pytest.fixture
def limited(tmp_path):
    """Jobs that wait, of tokens that may have two unfinished ones."""
    tokens = f"anna:{TOKEN},bert:{OTHER}"
    with idle_api(tmp_path, token=tokens, quota_running_jobs=2, quota_cases_per_day=50) as api:
        yield api


def asks(token, **headers):
    return {"headers": {"Authorization": f"Bearer {token}"} | headers}


def test_quotas_count_new_jobs_and_their_cases(limited):
    def post(document, **headers):
        return limited.ask("POST", "?fresh=true", document, **asks(TOKEN, **headers))

    assert_problem(post(sweep(51)), 413, says="51 cases exceeds")
    first = post(sweep(20), **{"Idempotency-Key": "a"})
    assert first.status_code == 202
    # neither a request that comes again nor one that is refused counts
    assert post(sweep(20), **{"Idempotency-Key": "a"}).json()["id"] == first.json()["id"]
    answer = post(sweep(40))
    assert_problem(answer, 429, says="what is left to the token 'anna'")
    assert int(answer.headers["retry-after"]) > 60
    assert post(sweep(20)).status_code == 202
    assert_problem(post(sweep(2)), 429, says="2 jobs of the token 'anna' are unfinished")


def test_jobs_that_go_on_again_count_as_unfinished_but_not_their_cases_twice(limited):
    """Whoever submits and cancels many may not have them all go on, nor have another token ask for it."""
    ids = []
    for _ in range(4):
        ids.append(limited.ask("POST", "?fresh=true", sweep(12), **asks(TOKEN)).json()["id"])
        limited.ask("POST", f"/{ids[-1]}:cancel", **asks(TOKEN))
    for job_id in ids[:2]:
        assert limited.ask("POST", f"/{job_id}:retry", **asks(TOKEN)).status_code == 202
    for token in (TOKEN, OTHER):
        answer = limited.ask("POST", f"/{ids[2]}:retry", **asks(token))
        assert_problem(answer, 429, says="2 jobs of the token 'anna' are unfinished, and 2 may be")
        assert answer.headers["retry-after"] == "60"
    assert limited.jobs.store.get(ids[2]).state == "cancelled"
    limited.ask("POST", f"/{ids[0]}:cancel", **asks(TOKEN))
    assert limited.ask("POST", f"/{ids[2]}:retry", **asks(TOKEN)).status_code == 202


def test_who_waits_for_running_jobs_is_told_when_the_first_of_them_will_end(limited):
    ids = [limited.ask("POST", "?fresh=true", sweep(12), **asks(TOKEN)).json()["id"] for _ in range(2)]
    store = limited.jobs.store
    store.claim("somebody", 60.0, most=2)
    counted = {"cases": 2, "failures": {}, "seconds": 1.0, "processor": "x"}
    for job_id, rate in zip(ids, (0.1, 0.05), strict=True):
        store.begin(job_id, "somebody")
        assert store.count_chunk(job_id, "somebody", 0, **counted, rate=rate)
    answer = limited.ask("POST", "?fresh=true", sweep(12), **asks(TOKEN))
    assert_problem(answer, 429, says="2 jobs of the token 'anna' are unfinished")
    assert answer.headers["retry-after"] == "100", "ten of its cases are left to the quicker one"


def test_a_job_of_an_earlier_version_without_warnings_is_shown(idle):
    job = idle.jobs.store.get(idle.ask("POST", "", sweep()).json()["id"])
    about = json.loads(job.about)
    del about["warnings"]
    record = idle.jobs.record(replace(job, about=json.dumps(about)))
    assert JobRecord.model_validate(record, strict=False).warnings == []


def test_a_paused_job_is_unfinished_already_and_may_go_on(limited):
    for _ in range(2):
        limited.ask("POST", "?fresh=true", sweep(2), **asks(TOKEN))
    store = limited.jobs.store
    for job in store.claim("somebody", 60.0, most=2):
        store.pause(job.id, "somebody", "the disk is full")
        assert limited.ask("POST", f"/{job.id}:resume", **asks(TOKEN)).json()["state"] == "queued"


def test_without_jobs_the_server_says_so():
    answer = ask("GET", JOBS, app=create_app(Settings(host="127.0.0.1", token=None)))
    assert_problem(answer, 503, says="keeps no jobs")
    assert answer.headers["retry-after"]


# listing


def test_lists_are_paged_filtered_and_searched(idle):
    ids = [idle.ask("POST", "?fresh=true", sweep(2, name=f"Job {k}")).json()["id"] for k in range(5)]
    idle.jobs.cancel(ids[3])
    seen, cursor = [], None
    while True:
        query = {"limit": 2} | ({"cursor": cursor} if cursor else {})
        page = JobPage.model_validate_json(idle.ask("GET", "", params=query).content)
        seen += [item.id for item in page.items]
        cursor = page.next
        if cursor is None:
            break
    assert seen == ids[::-1]
    assert [item["id"] for item in idle.get("?state=cancelled&state=failed")["items"]] == [ids[3]]
    assert [item["id"] for item in idle.get("?search=jOB 2")["items"]] == [ids[2]]
    assert idle.get("?search=%25")["items"] == [] and idle.get("?kind=monte_carlo")["items"] == []


@pytest.mark.parametrize("query", ["state=done", "kind=x", "limit=0", "limit=201", "cursor=abc", "search=%00"])
def test_odd_questions_are_refused(idle, query):
    assert_problem(idle.ask("GET", f"?{query}"), 422, says=query.split("=")[0])


@pytest.mark.parametrize("job_id", [NOBODY, "x", "%00", "...", "0" * 25 + "É"])
@pytest.mark.parametrize("what", ["", "/spec", "/events", "/cases", "/cases/0", "/results", "/summary"])
def test_jobs_that_are_not_there(idle, job_id, what):
    assert_problem(idle.ask("GET", f"/{job_id}{what}"), 404)


# states


def test_a_waiting_job_is_cancelled_at_once_and_deleted(idle):
    job_id = idle.ask("POST", "", sweep()).json()["id"]
    assert_problem(idle.ask("DELETE", f"/{job_id}"), 409, says="queued: cancel it first")
    assert_problem(idle.ask("POST", f"/{job_id}:resume"), 409, says="queued")
    assert_problem(idle.ask("POST", f"/{job_id}:retry"), 409, says="queued")
    answer = idle.ask("POST", f"/{job_id}:cancel")
    assert answer.status_code == 202 and answer.json()["state"] == "cancelled"
    assert answer.headers["location"] == f"{JOBS}/{job_id}"
    assert_problem(idle.ask("POST", f"/{job_id}:cancel"), 409, says="was cancelled")
    assert idle.ask("POST", f"/{job_id}:retry").json()["state"] == "queued"
    idle.ask("POST", f"/{job_id}:cancel")
    answer = idle.ask("DELETE", f"/{job_id}")
    assert answer.status_code == 204 and not answer.content
    assert_problem(idle.ask("GET", f"/{job_id}"), 404)


def test_the_batch_document_comes_back_and_gives_the_same_job(api):
    document = api.get(f"/{api.done}/spec")
    assert document["design"] == parse_design(glider()).model_dump(mode="json")
    again = api.ask("POST", "", document).json()
    assert again["id"] == api.done


def test_the_schema_is_the_documents_own(api):
    assert read_json(ask("GET", "/api/v1/schemas/batch", app=api.app)) == json.loads(json.dumps(batch_schema()))


def test_health_asks_the_engine_too(api):
    assert ask("GET", "/readyz", app=api.app).json()["checks"]["engine"] == "ok"
    assert "job_listeners" in ask("GET", "/metrics", app=api.app).text


def test_the_application_starts_and_stops_its_jobs(tmp_path):
    api = Api(tmp_path)

    async def live():
        async with api.app.router.lifespan_context(api.app):
            job, _ = api.jobs.submit(sweep(2))
            await asyncio.to_thread(finished, api.jobs, job)

    asyncio.run(live())
    assert not api.jobs.manager._thread.is_alive()
