"""Types of a form; `web/write_types.py` writes TypeScript interfaces of them and of `EntryDescription`."""

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
    """Ends of a slider in SI, whether it is logarithmic, and whether it is an integer."""

    low: float
    high: float
    log: bool
    whole: bool


class DisplayUnit(TypedDict):
    """Spelling and label of a unit, empty without one; displayed number = SI * factor + offset."""

    display_unit: str
    label: str
    factor: float
    offset: float


class EntryControl(EntryDescription):
    """Common data of all controls, in addition to the declaration."""

    path: str
    """Path in the document."""
    origin: Origin
    changed: bool
    """True if the value replaces a default or a value of the material."""


class NumberNode(EntryControl, DisplayUnit):
    """A number, with `unit` and `allowed` of its place."""

    sort: Literal["number"]
    value: float | None
    """SI; null if missing or without limit."""
    unlimited: bool
    usual: str | None
    """Default as text."""
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
    """One or several texts."""

    sort: Literal["text"]
    value: str
    several: bool


class RowNode(EntryControl):
    """A list of numbers or quantities, or an integer."""

    sort: Literal["row"]
    value: str
    several: bool
    quantities: bool
    """True if the items have units."""


class KindChoice(TypedDict):
    """The kind of a part, chosen from a registry."""

    path: str
    value: str
    registry: str
    changed: bool


class GroupNode(TypedDict):
    """A group of controls."""

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
    """The document, unless a kind needs unknown values."""

    text: str | None
    """Null if values are missing."""
    missing: list[SingleNode]
    refused: str
    """Sentence on missing entries; empty if complete."""


class ScenarioForm(MissingNumbers):
    """A scenario with a control for each entry."""

    title: str
    sections: list[GroupNode]
    registries: dict[str, list[NamedPart]]
    notes: list[str]
    assumed: list[str]
    """Paths of start values."""
