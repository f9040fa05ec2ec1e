"""Owns the command that puts measured data into a design: water, currents and forces from CSV or NetCDF."""

from __future__ import annotations

import csv
import sys
from argparse import Namespace
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from models.angle_csv import SPEED_HINT, holds_sideslip, read_angle_table_csv
from models.assemble import assemble
from models.design import Design, load_design, parse_design
from models.hydrodynamics import PolarTable, Provenance, RateTerms
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.polar_csv import read_polar_csv
from models.problems import DesignError, Problem, problems_from_validation
from models.profile_files import LATITUDE_HINT, read_current_profile, read_density_profile, read_water_profile
from studio.exit_codes import DONE, REFUSED, UNUSABLE

Table = PolarTable | AngleTable
AS_OPTIONS: Mapping[str | None, str] = {
    LATITUDE_HINT: "give --latitude: pressure and gravity follow from it",
    SPEED_HINT: "pick one by --speed, or --speed mean",
}
"""What a function's hint is called on the command line."""


def attach(options: Namespace) -> int:
    """Put data into a design and write it; a design that could not run is told, and written all the same."""
    told: list[str] = []
    try:
        changed = _changed(load_design(options.design), options, told)
        options.output.write_text(changed.to_json(), encoding="utf-8")
    except DesignError as error:
        for problem in error.problems:
            print(f"{options.data}: {_line(problem)}".replace("\n", " "), file=sys.stderr)
        return REFUSED
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        print(f"{options.design}, {options.data}: {error}", file=sys.stderr)
        return UNUSABLE
    told.append(f"written     {options.output}")
    try:
        told += [f"warning     {_line(warning)}" for warning in assemble(changed).warnings]
    except DesignError as error:
        told += [f"to mend     {_line(problem)}" for problem in error.problems]
    print("\n".join(told))
    return DONE


def _line(problem: Problem) -> str:
    return str(replace(problem, hint=AS_OPTIONS.get(problem.hint, problem.hint)))


def _changed(design: Design, options: Namespace, told: list[str]) -> Design:
    document = design.model_dump(mode="json")
    readers: dict[str, Callable[[], Any]] = {
        "water": lambda: read_water_profile(
            options.data, latitude=options.latitude, longitude=options.longitude, salinity_kind=options.salinity,
            source=options.source,
        ),
        "density": lambda: read_density_profile(options.data, source=options.source),
        "current": lambda: read_current_profile(options.data, source=options.source),
        "forces": lambda: _forces(design, options, told),
    }  # fmt: skip
    value = readers[options.kind]().model_dump(mode="json")
    if options.kind == "forces":
        document["vehicle"]["hydrodynamics"] = value
    else:
        document["mission"]["environment"]["current" if options.kind == "current" else "water"] = value
    return parse_design(document)


def _provenance(options: Namespace) -> Provenance:
    document = {"title": options.data.name[:200], "source": options.source or f"Read from {options.data.name}."}
    try:
        return Provenance.model_validate(document)
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None


def _forces(design: Design, options: Namespace, told: list[str]) -> Table:
    """Read a table over one angle or two, as its header says; what it does not hold stays as the former source had it.

    What stays, what is replaced and what is assumed of the table goes into `told`.
    """
    former = design.vehicle.hydrodynamics
    fields: dict[str, Any] = {
        "provenance": _provenance(options), "includes_munk_moment": options.munk == "included",
        "reference_density": options.reference_density, "reference_point": tuple(options.reference_point),
    }  # fmt: skip
    told.append(f"replaced    '{former.provenance.title}': forces and moments now come from {options.data.name}")
    table: Table
    if holds_sideslip(options.data):
        if not isinstance(former, CoefficientForm):
            fields["rates"] = _former_rates(former, options, told)
        table = read_angle_table_csv(options.data, speed=options.speed, **fields)
        if isinstance(former, PolarTable) and former.lateral is not None:
            told.append("replaced    lateral coefficients: side force, roll and yaw now come from the table")
    else:
        speed = None if options.speed == "mean" else options.speed
        table = read_polar_csv(options.data, speed=speed, lateral=_lateral(former, options, told), **fields)
    if isinstance(former, CoefficientForm):
        told.append(
            f"left out    rate terms of '{former.provenance.title}': they stand in the flow frame; state new ones"
        )
    told += _assumed(table)
    return table


def _former_rates(former: Table, options: Namespace, told: list[str]) -> dict[str, Any]:
    """Return the former rate terms, at the reference density of the new table."""
    rates = former.rates if isinstance(former, AngleTable) else former.lateral.rates if former.lateral else RateTerms()
    if rates == RateTerms(scaling=rates.scaling):
        told.append(f"left        rate terms: '{former.provenance.title}' has none; only vehicle.damping damps turning")
        return rates.model_dump()
    told.append(f"kept        rate terms of '{former.provenance.title}'{_scaled(former, options)}")
    return _at_density(rates.model_dump(), former, options)


def _lateral(former: Table | CoefficientForm, options: Namespace, told: list[str]) -> dict[str, Any] | None:
    """Return what a table over the angle of attack lacks: all that the former one stated, or its rate terms."""
    if isinstance(former, PolarTable) and former.lateral is not None:
        title, told_scaled = former.provenance.title, _scaled(former, options)
        told.append(f"kept        lateral coefficients and rate terms of '{title}'{told_scaled}")
        document = _at_density(former.lateral.model_dump(exclude={"rates"}), former, options)
        document["rates"] = _at_density(former.lateral.rates.model_dump(), former, options)
        return document
    if isinstance(former, AngleTable):
        told.append("lost        side force, roll and yaw by sideslip: a table over alpha_deg alone has none")
        rates = _former_rates(former, options, told)
        source = f"Rate terms of '{former.provenance.title}'; no coefficients of sideslip are known."
        return {"source": source, "rates": rates}
    return None


def _at_density(document: dict[str, Any], former: Table, options: Namespace) -> dict[str, Any]:
    """Return coefficients that give at the new reference density what they gave at the former one."""
    share = options.reference_density / former.reference_density
    return {name: share * value if isinstance(value, float) else value for name, value in document.items()}


def _scaled(former: Table, options: Namespace) -> str:
    old, new = former.reference_density, options.reference_density
    return "" if old == new else f", scaled from {old:g} to {new:g} kg/m3"


def _assumed(table: Table) -> list[str]:
    holds, otherwise = ("hold", "excluded") if table.includes_munk_moment else ("do not hold", "included")
    point = ", ".join(f"{x:g}" for x in table.reference_point)
    return [
        f"assumed     the moments {holds} the Munk moment (--munk {otherwise} if not)",
        f"assumed     taken at {table.reference_density:g} kg/m3 (--reference-density if not)",
        f"assumed     moments about ({point}) m in body axes (--reference-point if not)",
    ]
