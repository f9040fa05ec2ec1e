"""Owns remembering what follows from a description: descriptions never change, so an answer found once stays true.

Designs that vary in a few fields share all other objects (variation.py), which makes thousands of cases cheap to weigh
and check. Answers are kept by the object itself, not by its value, which for a table of forces takes long to hash.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

AboutT = TypeVar("AboutT")
AnswerT = TypeVar("AnswerT")
More = ParamSpec("More")


def remembered(
    *, most: int, about: int = 1
) -> Callable[[Callable[Concatenate[AboutT, More], AnswerT]], Callable[Concatenate[AboutT, More], AnswerT]]:
    """Return a decorator for a pure function of descriptions, the first `about` arguments, and of hashable values.

    Up to `most` answers are kept, and with them the descriptions they are about; callers share an answer and must not
    change it.
    """

    def decorate(
        function: Callable[Concatenate[AboutT, More], AnswerT],
    ) -> Callable[Concatenate[AboutT, More], AnswerT]:
        known: dict[tuple[Hashable, ...], tuple[tuple[Any, ...], AnswerT]] = {}

        alone, others = about == 1, about - 1

        @wraps(function)
        def answer(first: AboutT, *more: Any) -> AnswerT:
            key = (id(first), more) if alone else (id(first), *map(id, more[:others]), more[others:])
            held = known.get(key)
            if held is not None:  # it holds the descriptions, so no others can have their ids
                return held[1]
            found = function(first, *more)  # type: ignore[call-arg]
            if len(known) >= most:
                known.clear()
            known[key] = ((first, more), found)
            return found

        return answer  # type: ignore[return-value]

    return decorate


def remembered_for_life(
    function: Callable[Concatenate[AboutT, More], AnswerT],
) -> Callable[Concatenate[AboutT, More], AnswerT]:
    """Remember what a pure function says of an object, which is hashed by its identity, as long as that object lives.

    Further arguments are hashable; callers share an answer and must not change it.
    """
    known: WeakKeyDictionary[AboutT, dict[tuple[Hashable, ...], AnswerT]] = WeakKeyDictionary()

    @wraps(function)
    def answer(about: AboutT, *more: Any) -> AnswerT:
        answers = known.setdefault(about, {})
        if more not in answers:
            answers[more] = function(about, *more)  # type: ignore[call-arg]
        return answers[more]

    return answer  # type: ignore[return-value]
