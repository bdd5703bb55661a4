"""Types of a form as it is sent; the page's TypeScript is written from this file.

`web/write_types.py` turns every table here, and `EntryDescription`, into an interface.
"""

from __future__ import annotations

from typing import Literal, NotRequired, TypedDict

from martensite.scenario.catalogue import EntryDescription, NamedPart


class Origin(TypedDict):
    """Origin of a value."""

    sort: str
    """scenario, start, default, plant, none, law or material."""
    words: str
    kind: NotRequired[str]
    """Kind of a material value: datasheet, measured, fitted, assumed or recalled."""
    doubtful: NotRequired[bool]
    source: NotRequired[str]
    cite: NotRequired[str]
    where: NotRequired[str]
    note: NotRequired[str]


class MaterialValue(Origin):
    """Value of the material for a parameter that the scenario sets."""

    text: str
    value: float


class SliderRange(TypedDict):
    """Ends of a slider in SI, whether it is logarithmic, and whether it goes in whole numbers."""

    low: float
    high: float
    log: bool
    whole: bool


class DisplayUnit(TypedDict):
    """Unit as it is written and as it is read, empty for none; shown = SI * factor + offset."""

    shown: str
    label: str
    factor: float
    offset: float


class EntryControl(EntryDescription):
    """Common data of the controls of all entries, in addition to the declaration."""

    path: str
    """In the document."""
    origin: Origin
    changed: bool
    """True if the value replaces a default or a value of the material."""


class NumberNode(EntryControl, DisplayUnit):
    """A number; `unit` and `allowed` are those of its place."""

    sort: Literal["number"]
    value: float | None
    """SI; null where there is none yet, or no limit."""
    unlimited: bool
    usual: str | None
    """The default in words."""
    slider: SliderRange | None
    material: MaterialValue | None


class OptionNode(EntryControl):
    """A choice between words."""

    sort: Literal["option"]
    value: str


class MaterialNode(EntryControl):
    """The choice of a material."""

    sort: Literal["material"]
    value: str
    materials: list[NamedPart]
    about: str
    limits: str


class TextNode(EntryControl):
    """A free text, or several."""

    sort: Literal["text"]
    value: str
    several: bool


class RowNode(EntryControl):
    """A list of numbers or quantities, or a whole number, as the document holds it."""

    sort: Literal["row"]
    value: str
    several: bool
    quantities: bool
    """True if the items carry units."""


class KindChoice(TypedDict):
    """The kind of a part, chosen from a registry."""

    path: str
    value: str
    registry: str
    changed: bool


class GroupNode(TypedDict):
    """Controls that belong together."""

    sort: Literal["group"]
    path: str
    title: str
    meaning: str
    note: str
    kind: KindChoice | None
    items: list[FormNode]


SingleNode = NumberNode | OptionNode | MaterialNode | TextNode | RowNode
FormNode = SingleNode | GroupNode


class MissingNumbers(TypedDict):
    """The document, unless a kind needs numbers that nothing is known for."""

    text: str | None
    """Null if something is missing."""
    missing: list[SingleNode]
    refused: str
    """Missing entries, in a sentence; empty if complete."""


class ScenarioForm(MissingNumbers):
    """A scenario with a control for all that it declares."""

    title: str
    sections: list[GroupNode]
    registries: dict[str, list[NamedPart]]
    notes: list[str]
    assumed: list[str]
    """Paths of start values."""
