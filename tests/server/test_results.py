"""A job's chunk files as one table: pages, cases and batches hold each case that counts once, and nothing else."""

from __future__ import annotations

import pytest

from server.jobs import results as module
from server.jobs.files import JobFiles
from server.jobs.results import LostResultsError, Results
from server.jobs.task import ChunkResult
from tests.server.results_support import COLUMNS, METRICS, PARAMETERS, REASON, case_row, made_up


def paged(results, *, limit=7, status=None):
    """Return all cases of all pages, and how many pages there were."""
    found, after, pages = [], -1, 0
    while after is not None:
        items, after = results.page(after, limit, status)
        assert len(items) <= limit
        found += items
        pages += 1
    return found, pages


def numbers(records):
    return [record["case"] for record in records]


def expected(case):
    """Return a case as a page shows it."""
    row = case_row(case)
    return {
        "case": case, "status": row.status, "reason": row.reason,
        "parameters": dict(zip(PARAMETERS, row.values, strict=True)),
        "metrics": {name: None if v != v else v for name, v in zip(METRICS, row.metrics, strict=True)},
    }  # fmt: skip


@pytest.mark.parametrize("limit", [1, 7, 8, 33, 99, 100, 101, 1000])
def test_pages_hold_every_case_once(tmp_path, limit):
    found, pages = paged(made_up(tmp_path), limit=limit)
    assert found == [expected(case) for case in range(100)]
    assert pages == -(-100 // limit)  # none is empty, the last included


def test_columns_keep_what_they_mean(tmp_path):
    assert made_up(tmp_path).columns() == list(COLUMNS)


@pytest.mark.parametrize("status", [{"refused"}, {"diverged", "refused"}, {"completed"}, {"bed"}, set()])
def test_pages_of_one_status(tmp_path, status):
    found, _ = paged(made_up(tmp_path), limit=3, status=status)
    assert numbers(found) == [case for case in range(100) if case_row(case).status in status]
    assert all(record["reason"] == REASON for record in found if record["status"] == "refused")


def test_chunks_that_are_missing_are_passed_over(tmp_path):
    results = made_up(tmp_path, without={0, 3, 4, 12})
    there = [case for case in range(100) if case // 8 not in {0, 3, 4, 12}]
    assert numbers(paged(results)[0]) == there
    assert [n for batch in results.batches() for n in batch.column(0).to_pylist()] == there
    assert results.count() == len(there) and results.chunks() == [1, 2, *range(5, 12)]
    assert results.case(7) is None and results.case(8) == expected(8)


@pytest.mark.parametrize("counted", [1, 8, 20, 21, 96, 100])
def test_cases_beyond_an_early_stop_do_not_count(tmp_path, counted):
    results = made_up(tmp_path, counted=counted)
    assert numbers(paged(results)[0]) == list(range(counted))
    assert [batch.num_rows for batch in results.batches()] == [8] * (counted // 8) + [counted % 8] * (counted % 8 > 0)
    assert results.count() == counted
    assert results.case(counted) is None and results.case(counted - 1) == expected(counted - 1)


def test_case_numbers_that_are_none(tmp_path):
    results = made_up(tmp_path)
    assert [results.case(number) for number in (-1, 100, 10**12)] == [None] * 3


def test_one_batch_a_chunk_with_the_wanted_columns(tmp_path):
    results = made_up(tmp_path)
    assert [batch.num_rows for batch in results.batches()] == [8] * 12 + [4]
    for batch in results.batches(["range", "case"]):
        assert batch.schema.names == ["range", "case"]
        assert batch.column(0).to_pylist() == [expected(n)["metrics"]["range"] for n in batch.column(1).to_pylist()]


def test_blocks_join_chunks_and_lose_nothing(tmp_path, monkeypatch):
    results = made_up(tmp_path)
    whole = [n for batch in results.batches() for n in batch.to_pylist()]
    monkeypatch.setattr(module, "VALUES_A_BLOCK", 8 * 11 * 3)
    blocks = list(results.blocks())
    assert [block.num_rows for block in blocks] == [24, 24, 24, 24, 4]
    assert [n for block in blocks for n in block.to_pylist()] == whole


def test_a_page_looks_through_few_chunks_and_says_where_to_go_on(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MOST_CHUNKS_A_PAGE", 2)
    results = made_up(tmp_path)
    assert results.page(-1, 10, {"bed"}) == ([], 15)
    assert numbers(paged(results, status={"refused"})[0]) == list(range(6, 100, 7))


def test_a_job_of_which_nothing_is_done(tmp_path):
    results = Results(JobFiles(tmp_path, "job"), cases=10, chunk_size=4)
    assert results.page(-1, 10) == ([], None)
    assert results.columns() == [] and results.case(0) is None and list(results.batches()) == []
    assert results.schema.names == ["case", "status", "reason"]


def test_results_that_vanish_while_they_are_read_are_not_taken_for_the_end(tmp_path):
    results = made_up(tmp_path)
    batches = results.batches()
    next(batches)
    results.files.path(1).unlink()
    with pytest.raises(LostResultsError, match="cases 8 to 15 are gone"):
        next(batches)


def test_a_damaged_file_is_told(tmp_path):
    results = made_up(tmp_path)
    results.files.path(2).write_bytes(b"PAR1 and nonsense")
    with pytest.raises(LostResultsError, match="cases 16 to 23 cannot be read"):
        list(results.batches())


def test_a_chunk_that_is_computed_again_takes_the_place_of_the_old_one(tmp_path):
    results = made_up(tmp_path)
    assert results.case(20)["status"] == "refused"
    table = module.pa.Table.from_batches(list(results.batches()))
    repaired = table.slice(16, 8).set_column(1, table.schema.field(1), [["completed"] * 8])
    content = module.pa.BufferOutputStream()
    module.pq.write_table(repaired, content)
    results.files.write(2, ChunkResult(content.getvalue().to_pybytes(), None, 8, 0.0, "kernel", "processor"))
    assert results.case(20)["status"] == "completed"
