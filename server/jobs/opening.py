"""Owns how the jobs of a program are opened: its settings say who computes and where results go."""

from __future__ import annotations

from models.design import Design
from models.problems import DesignError, Problem
from server.jobs.engines import make_engine
from server.jobs.service import Jobs
from server.jobs.submission import FindDesign
from server.settings import Settings
from server.store.designs import DesignStore
from server.store.errors import DeletedError, NotFoundError
from server.store.identifiers import is_id

DESIGNS = "/api/v1/designs"
"""Where whoever sends a batch document finds the designs that there are."""


def open_jobs(settings: Settings, store: DesignStore) -> Jobs:
    """Return the jobs beside a store of designs, in its database; nothing runs before they are started."""
    return Jobs(
        store.database, make_engine(settings.scheduler, workers=settings.workers), settings.data / "jobs",
        find_design=finder(store), limits=settings.limits, max_cases=settings.max_cases,
        reserve=settings.min_free_mib * 2**20,
    )  # fmt: skip


def finder(store: DesignStore) -> FindDesign:
    """Return how a batch document's `design_id` becomes a design and its revision."""

    def find(design_id: str, revision: int | None) -> tuple[Design, int]:
        try:
            if not is_id(design_id):
                raise NotFoundError(f"there is no design {design_id!r}")
            stored = store.get(design_id) if revision is None else store.revision(design_id, revision)
        except (NotFoundError, DeletedError) as error:
            pointer = "/design_id" if revision is None else "/revision"
            listed = "" if revision is None else f"/{design_id}/revisions"
            hint = f"GET {DESIGNS}{listed} lists those there are"
            raise DesignError([Problem(pointer, str(error), hint=hint)]) from None
        return stored.design, stored.revision

    return find
