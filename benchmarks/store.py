"""Lists, searches and pages of a full store, against 20 ms at the 95th percentile: `python -m benchmarks.store [URL]`.

SQLite in a temporary folder, or the empty database that the URL names. Notes are as long as those of the presets.
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from models.design import parse_design
from models.presets import load_preset
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.listing import DesignQuery
from server.store.records import Content

DESIGNS = 10_000
REPEATS = 100
TARGET = 20.0  # ms at the 95th percentile
WORDS = 3000


def fill(store: DesignStore) -> float:
    """Store the designs; return the milliseconds that one took."""
    dice = random.Random(7)
    words = ["".join(dice.choices("abcdefghilmnoprstu", k=dice.randint(3, 10))) for _ in range(WORDS)]
    document = load_preset("seawing-spiral").model_dump(mode="json")
    begin = time.perf_counter()
    for k in range(DESIGNS):
        named = document | {"name": f"Glider {k} {dice.choice(words)}", "notes": " ".join(dice.choices(words, k=150))}
        store.create(Content(parse_design(named), tuple(dice.sample(words[:50], 3))))
    return 1e3 * (time.perf_counter() - begin) / DESIGNS


def percentiles(action: Callable[[], object]) -> tuple[float, float]:
    """Return the 50th and 95th percentile of the time an action takes, ms."""
    taken = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        action()
        taken.append(1e3 * (time.perf_counter() - begin))
    median, high = np.percentile(taken, [50, 95])
    return float(median), float(high)


def queries(store: DesignStore) -> dict[str, DesignQuery]:
    """Return what is asked, by name; the page in the middle of a list has a cursor."""
    listed = store.find(DesignQuery(limit=1)).items[0]
    middle = store.find(DesignQuery(order="name", limit=200)).next
    return {
        "list": DesignQuery(),
        "list by name": DesignQuery(order="name"),
        "page within": DesignQuery(order="name", cursor=middle),
        "by tag": DesignQuery(tags=(listed.tags[0],)),
        "search one": DesignQuery(f"{listed.name}"),
        "search all": DesignQuery("glider"),
        "search none": DesignQuery("zzzyyyxxx"),
        "search a part": DesignQuery("ati"),
        "search two parts": DesignQuery("ati ero"),
        "search two letters": DesignQuery("qx"),
        "search and tag": DesignQuery("ati", (listed.tags[0],), order="name"),
    }


def main(store: DesignStore) -> None:
    """Fill, ask and print."""
    print(f"{DESIGNS} designs, {fill(store):.2f} ms to store one")
    print(f"{'':20} p50, ms  p95, ms  (target {TARGET:g} ms at p95)")
    for name, query in queries(store).items():
        median, high = percentiles(lambda query=query: store.find(query))
        print(f"{name:20} {median:7.2f}  {high:7.2f}  {'' if high < TARGET else 'above the target'}")
    design_id = store.find(DesignQuery(limit=1)).items[0].id
    print("{:20} {:7.2f}  {:7.2f}".format("get one", *percentiles(lambda: store.get(design_id).design)))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        database = Database(sys.argv[1] if len(sys.argv) > 1 else sqlite_url(Path(folder) / "studio.sqlite"))
        main(DesignStore(database))
        database.close()
