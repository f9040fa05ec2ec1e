"""Owns the command that puts measured data into a design: water, currents and forces from CSV or NetCDF."""

from __future__ import annotations

import csv
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import Any

from models.angle_csv import read_angle_table_csv
from models.assemble import assemble
from models.design import Design, load_design, parse_design
from models.hydrodynamics import PolarTable, Provenance
from models.polar_csv import read_polar_csv
from models.problems import DesignError
from models.profile_files import read_current_profile, read_density_profile, read_water_profile
from studio.exit_codes import DONE, REFUSED, UNUSABLE


def attach(options: Namespace) -> int:
    """Put data into a design and write it; a design that could not run is told, and written all the same."""
    try:
        design = load_design(options.design)
        changed = _changed(design, options)
        options.output.write_text(changed.to_json(), encoding="utf-8")
    except DesignError as error:
        for problem in error.problems:
            print(f"{options.data}: {problem}".replace("\n", " "), file=sys.stderr)
        return REFUSED
    except (OSError, UnicodeDecodeError) as error:
        print(f"{options.design}, {options.data}: {error}", file=sys.stderr)
        return UNUSABLE
    print(f"written     {options.output}")
    try:
        warnings = [f"warning     {warning}" for warning in assemble(changed).warnings]
    except DesignError as error:
        warnings = [f"to mend     {problem}" for problem in error.problems]
    print("\n".join(warnings), end="\n" if warnings else "")
    return DONE


def _changed(design: Design, options: Namespace) -> Design:
    document = design.model_dump(mode="json")
    readers: dict[str, Callable[[], Any]] = {
        "water": lambda: read_water_profile(
            options.data, latitude=options.latitude, longitude=options.longitude, salinity_kind=options.salinity,
            source=options.source,
        ),
        "density": lambda: read_density_profile(options.data, source=options.source),
        "current": lambda: read_current_profile(options.data, source=options.source),
        "forces": lambda: _forces(design, options),
    }  # fmt: skip
    value = readers[options.kind]().model_dump(mode="json")
    if options.kind == "forces":
        document["vehicle"]["hydrodynamics"] = value
    else:
        document["mission"]["environment"]["current" if options.kind == "current" else "water"] = value
    return parse_design(document)


def _forces(design: Design, options: Namespace) -> Any:
    """Read a table over one angle or two, as its header says; lateral coefficients of the former table stay."""
    with options.data.open(encoding="utf-8-sig", newline="") as lines:
        header = next(csv.reader(lines), [])
    provenance = Provenance(title=options.data.name[:200], source=options.source or f"Read from {options.data.name}.")
    if "beta_deg" in header:
        speed = options.speed if options.speed in (None, "mean") else float(options.speed)
        return read_angle_table_csv(options.data, provenance=provenance, speed=speed)
    former = design.vehicle.hydrodynamics
    kept: dict[str, Any] = {"lateral": former.lateral} if isinstance(former, PolarTable) else {}
    if options.speed not in (None, "mean"):
        kept["speed"] = float(options.speed)
    return read_polar_csv(options.data, provenance=provenance, **kept)
