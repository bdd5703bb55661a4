"""Answers kept for an object: computed once, never those of another object, and gone with the object.

Truth: the function itself, called again, and the garbage collector.
"""

import gc
from weakref import ref

from martensite.base.remember_results import remember


class Part:
    """A frozen object; all are equal."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Part)

    def __hash__(self) -> int:
        return 0


def test_an_answer_is_computed_once_for_every_object_and_released_with_it() -> None:
    calls: list[int] = []

    @remember
    def answer(part: Part) -> list[int]:
        calls.append(part.number)
        return [part.number]

    one, two = Part(1), Part(2)
    assert (answer(one), answer(two), answer(one)) == ([1], [2], [1])
    assert calls == [1, 2]
    known = ref(one)
    del one
    gc.collect()
    assert known() is None
    made = [answer(Part(number)) for number in range(100)]  # later objects take the place of released ones
    assert made == [[number] for number in range(100)]
