"""Components are found by the annotation of a declaration, whether a module puts off reading it or not.

Source of truth: the classes that the annotations name. This module does not put it off.
"""

from typing import Any

from martensite.base.parameters import Parametrised, part
from martensite.base.part_kinds import find_annotated
from martensite.physics.thermal.base import Environment
from martensite.scenario.components import component_class, is_plain


class Written(Parametrised):
    """Annotations that are texts."""

    around: "Environment" = part("surroundings")
    other: "Environment | None" = part("other surroundings", default=None)
    count: "int" = part("how many", default=1)
    several: "tuple[Environment, ...]" = part("more surroundings", default=())
    rows: "Any" = part("numbers", default=())


class Read(Parametrised):
    """The same, as what they name."""

    around: Environment = part("surroundings")
    other: Environment | None = part("other surroundings", default=None)
    count: int = part("how many", default=1)
    several: tuple[Environment, ...] = part("more surroundings", default=())
    rows: Any = part("numbers", default=())


def test_annotations_name_components_either_way() -> None:
    for cls in (Written, Read):
        assert [component_class(cls, name) for name in ("around", "other")] == [Environment, Environment]
        assert [is_plain(cls, name) for name in ("around", "other", "count", "rows")] == [False, False, True, True]
        assert find_annotated(cls, "count") == (int,)
        assert find_annotated(cls, "several") == (tuple,)
