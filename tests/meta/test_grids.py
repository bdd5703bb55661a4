"""A loop of cases in one test runs them all, and says at which one it stopped."""

import pytest
from grids import over


def test_every_case_is_run_and_the_one_that_fails_is_named() -> None:
    seen = []

    @over("b", [10, 20])
    @over("a", [1, 2, 3])
    def check(self: None, a: int, b: int) -> None:
        seen.append(a + b)
        assert a + b < 23

    with pytest.raises(AssertionError) as caught:
        check(None)
    assert seen == [11, 12, 13, 21, 22, 23]
    assert caught.value.__notes__ == ["at a = 3", "at b = 20"]
