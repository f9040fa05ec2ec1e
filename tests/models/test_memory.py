"""Answers are remembered by the object that they are about, and only pure questions may be asked."""

from __future__ import annotations

import gc
import weakref

import pytest

from models.memory import remembered, remembered_for_life


class Thing:
    """Something that is equal to every other of its value."""

    def __init__(self, value: float) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Thing) and other.value == self.value

    def __hash__(self) -> int:
        return hash(self.value)


def asked(most: int):
    questions: list[tuple[float, float]] = []

    @remembered(most=most)
    def product(thing: Thing, factor: float) -> float:
        questions.append((thing.value, factor))
        return thing.value * factor

    return product, questions


def test_the_same_object_is_asked_once_for_each_value():
    product, questions = asked(10)
    thing = Thing(3.0)
    assert [product(thing, f) for f in (2.0, 2.0, 4.0, 2.0)] == [6.0, 6.0, 12.0, 6.0]
    assert questions == [(3.0, 2.0), (3.0, 4.0)]


def test_an_equal_object_is_another():
    product, questions = asked(10)
    assert product(Thing(3.0), 2.0) == product(Thing(3.0), 2.0) == 6.0
    assert len(questions) == 2


def test_answers_stay_right_beyond_what_is_kept():
    """Objects die and others get their places in memory: no answer may be taken for theirs."""
    product, _ = asked(7)
    assert [product(Thing(float(k)), 2.0) for k in range(1000)] == [2.0 * k for k in range(1000)]


def test_several_objects_are_told_apart_by_what_they_are_not_by_their_value():
    questions: list[tuple[float, float]] = []

    @remembered(most=10, about=2)
    def product(thing: Thing, other: Thing, factor: float) -> float:
        questions.append((thing.value, other.value))
        return thing.value * other.value * factor

    two, three = Thing(2.0), Thing(3.0)
    assert [product(two, three, 1.0), product(three, two, 1.0), product(two, three, 1.0)] == [6.0, 6.0, 6.0]
    assert product(two, Thing(3.0), 1.0) == 6.0
    assert questions == [(2.0, 3.0), (3.0, 2.0), (2.0, 3.0)]


def test_answers_about_several_stay_right_beyond_what_is_kept():
    @remembered(most=7, about=2)
    def difference(thing: Thing, other: Thing) -> float:
        return thing.value - other.value

    assert [difference(Thing(float(k)), Thing(1.0)) for k in range(1000)] == [k - 1.0 for k in range(1000)]


def test_what_the_key_would_not_hold_is_refused():
    product, _ = asked(10)
    with pytest.raises(TypeError):
        product(Thing(3.0), factor=2.0)


class Lasting:
    """Something that is equal to itself alone, as a run is."""


def test_an_answer_lasts_as_long_as_what_it_is_about():
    questions: list[int] = []

    @remembered_for_life
    def told(thing: Lasting, number: int) -> list[int]:
        questions.append(number)
        return [number]

    thing, other = Lasting(), Lasting()
    first = told(thing, 1)
    assert told(thing, 1) is first and told(thing, 2) == [2] and told(other, 1) == [1]
    assert questions == [1, 2, 1]
    gone = weakref.ref(thing)
    del thing
    gc.collect()
    assert gone() is None
