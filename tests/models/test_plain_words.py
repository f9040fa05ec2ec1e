"""A batch document of a wrong shape is told in plain words: what is wanted there, and which name was probably meant."""

from __future__ import annotations

import copy

import pytest

from models.problems import DesignError, Problem
from server.jobs.spec import parse_spec
from tests.server.test_batch_spec import DENSITY, EXAMPLES, document, drawn, factorial, monte_carlo, ranged, refused


@pytest.mark.parametrize(
    ("given", "pointer", "words"),
    [
        (document() | {"metrics": "range"}, "/metrics", "a list is wanted, not 'range'"),
        (document() | {"name": 3}, "/name", "text is wanted, not 3"),
        (document() | {"seed": 1.5}, "/seed", "a whole number is wanted, not 1.5"),
        ({"format": "glider-batch", "version": 1}, "/kind", "the kind is missing (use one of 'monte_carlo', 'sens"),
        (document("sweeep"), "/kind", "there is no kind 'sweeep' (did you mean sweep? use one of 'simulate', 'sweep'"),
        (document("sweep"), "/method", "the field 'method' is missing (add this field)"),
        (document("sweep", method=3), "/method", "an object is wanted, not 3 (its fields are kind)"),
        (document("sweep", method={"kind": "full_factoral"}), "/method/kind", "(did you mean full_factorial? use one"),
        (factorial("x"), "/method/parameters/0", "an object is wanted, not 'x' (its fields are pointer, name, also, v"),
        (factorial(ranged(count=3, hihg=1.0)), "/method/parameters/0/hihg", "'hihg' here (did you mean high?)"),
        (factorial(ranged(count=3, also=[{"pointer": DENSITY, "facter": 1}])), "/method/parameters/0/also/0/facter",
         "(did you mean factor?)"),
        (monte_carlo(drawn(kind="normal", mean=1, sd=1, widest=2)), "/parameters/0/distribution/widest",
         "there is no field 'widest' here (remove it; there are kind, mean, sd)"),
        (monte_carlo(drawn(), correlations=[{"between": ["a"], "value": 0.1}]), "/correlations/0/between/1",
         "entry 2 is missing (add this entry)"),
        (monte_carlo(drawn(), stop={"metric": "range", "width": 1.0, "statistic": "medien"}), "/stop/statistic",
         "(did you mean median"),
    ],
)  # fmt: skip
def test_what_is_wanted_is_told_where_something_else_stands(given, pointer, words):
    refused(given, pointer, words)


PYDANTICS_OWN = ("Input should", "Extra inputs", "Field required", "valid tuple", "valid dictionary", "instance of")


@pytest.mark.parametrize("name", list(EXAMPLES))
@pytest.mark.parametrize("odd", [None, True, 3, 1.5, "x", "", [], {}, [[]], {"kind": "x"}], ids=repr)
def test_no_document_is_answered_in_the_words_of_a_library(name, odd):
    """Whichever value of an example, the design's aside, an odd one stands in place of."""

    def spoilt(node):
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            if key in ("design", "format", "version"):
                continue
            node[key] = odd
            yield
            node[key] = value
            if isinstance(value, dict | list):
                yield from spoilt(value)

    given = copy.deepcopy(EXAMPLES[name])
    for _ in spoilt(given):
        try:
            parse_spec(given)
        except DesignError as error:
            for problem in error.problems:
                assert not any(words in problem.message for words in PYDANTICS_OWN), problem


def test_only_what_is_at_a_place_names_it():
    assert str(Problem("/vehicle", "too much", hint="send less")) == "/vehicle: too much (send less)"
    assert str(Problem("", "too much", hint="send less")) == "too much (send less)"
    assert str(DesignError([Problem("", "no"), Problem("/x", "too much")])) == "no; /x: too much"
