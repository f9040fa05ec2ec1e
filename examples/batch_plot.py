"""Draw the table of a sweep over two parameters: `python examples/batch_plot.py cases.parquet map.png [METRIC]`."""

from __future__ import annotations

import sys

import matplotlib
import matplotlib.pyplot as plt
import pyarrow.parquet as pq

matplotlib.use("Agg")  # a file, no window


def main(table: str, picture: str, metric: str = "range") -> None:
    """Colour each case by a metric; columns know their units and what they are."""
    schema = pq.read_schema(table)
    about = {f.name: {key.decode(): value.decode() for key, value in (f.metadata or {}).items()} for f in schema}
    x, y = [name for name, told in about.items() if told.get("role") == "parameter"][:2]
    cases = pq.read_table(table, columns=["case", x, y, metric]).drop_null()  # those that have this metric
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    shown = axes.tripcolor(cases[x], cases[y], cases[metric], shading="gouraud")
    figure.colorbar(shown, label=f"{metric} ({about[metric]['unit']})")
    axes.set(xlabel=f"{x} ({about[x]['unit']})", ylabel=f"{y} ({about[y]['unit']})", title=about[metric]["meaning"])
    figure.savefig(picture, dpi=150)
    best = cases.sort_by([(metric, "descending")]).slice(0, 1).to_pylist()[0]
    where = ", ".join(f"{name} {best[name]:.4g}" for name in (x, y, metric))
    print(f"written {picture}; most {metric} in case {best['case']}: {where}")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        main(*sys.argv[1:4])
    else:
        print(__doc__)
