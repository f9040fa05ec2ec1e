"""The JSON Schema of the design: every field says what it is, every number its unit and symbol."""

from models.design import Design

SCHEMA = Design.model_json_schema()
NUMBERS = {"number", "integer"}


def fields():
    """Every property of every model: model, name, schema."""
    models = {"Design": SCHEMA} | SCHEMA["$defs"]
    for model, schema in models.items():
        for name, field in schema.get("properties", {}).items():
            yield model, name, field


def resolved(schema):
    """A schema with its reference followed."""
    reference = schema.get("$ref")
    return SCHEMA["$defs"][reference.rsplit("/", 1)[1]] if reference else schema


def within(schema):
    """The schemas of what a field's schema holds: choices, entries of arrays, values of maps."""
    parts = [*schema.get("anyOf", []), *schema.get("prefixItems", []), *schema.get("patternProperties", {}).values()]
    return parts + [schema[key] for key in ("items", "additionalProperties") if isinstance(schema.get(key), dict)]


def holds_numbers(schema):
    """Whether a field is a number or a collection of numbers, and not another model."""
    schema = resolved(schema)
    if "properties" in schema or "const" in schema or "discriminator" in schema:
        return False
    if schema.get("type") in NUMBERS:
        return True
    inside = within(schema)
    return any(holds_numbers(item) for item in inside)


def test_the_walk_reaches_every_model():
    models = {model for model, _, _ in fields()}
    assert {"Design", "Vehicle", "Bellows", "PolarTable", "SchedulePoint", "BellowsShape", "Solver"} <= models
    assert len(list(fields())) > 100


def test_every_field_has_a_sentence():
    """Where it says the same as the model it refers to, the schema keeps that one only."""
    lacking = [
        f"{model}.{name}" for model, name, field in fields()
        if not field.get("description", resolved(field).get("description", "")).endswith(".")
    ]  # fmt: skip
    assert lacking == []


def test_every_model_has_a_sentence():
    models = {"Design": SCHEMA} | SCHEMA["$defs"]
    assert [model for model, schema in models.items() if not schema.get("description")] == []


def test_every_number_has_a_unit_and_a_symbol():
    lacking = [
        f"{model}.{name}" for model, name, field in fields()
        if holds_numbers(field) and not (field.get("unit") and field.get("symbol"))
    ]  # fmt: skip
    assert lacking == []


def test_words_have_neither():
    odd = [
        f"{m}.{n}" for m, n, field in fields() if not holds_numbers(field) and ("unit" in field or "symbol" in field)
    ]
    assert odd == []


def bounded(schema):
    """Whether every number within a field has bounds on both sides."""
    schema = resolved(schema)
    if schema.get("type") in NUMBERS and "const" not in schema:
        low = {"minimum", "exclusiveMinimum"} & set(schema)
        high = {"maximum", "exclusiveMaximum"} & set(schema)
        return bool(low and high)
    return all(bounded(part) for part in within(schema))


def test_every_number_has_limits():
    assert [f"{m}.{n}" for m, n, field in fields() if holds_numbers(field) and not bounded(field)] == []
