"""The form of a scenario."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, cast

from martensite.app.documents import read_request_scenario
from martensite.app.forms import controls, documents
from martensite.app.forms.changed_scenario import ChangedScenario
from martensite.app.forms.controls import Control, EntrySpot
from martensite.app.forms.kind_change import change_kind
from martensite.app.forms.sections import MATERIAL, FormSections
from martensite.app.forms.table_filler import MissingNumber
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.worker import Desk
from martensite.base.files import toml_document
from martensite.scenario.catalogue import list_registries, summarise_class
from martensite.scenario.overrides import as_toml
from martensite.scenario.scenario import Scenario

NEW = Path(__file__).parents[1] / "forms" / "new.toml"


def build_form(request: Request, desk: Desk) -> JsonTable:
    """The form of a scenario: a control for all that it declares.

    {"text": TOML, "changes": {path: value}, "removed": [path]}
    -> {"text": TOML with the changes, "sections": [group],
        "registries": {registry: [{name, summary}]}, "notes": [sentence],
        "assumed": [path], "missing": []}

    A text that is empty is a new scenario. A change of `element.material`, or of a path that ends
    in `.kind`, takes the rest of the document with it (`forms.kind_change`). If a kind needs
    numbers that nothing is known for, `text` is null, `refused` a sentence, and `missing` their
    controls; the same changes with these numbers beside them are the next request.
    """
    text = require_entry(request, "text", str, "") or NEW.read_text("utf-8")
    changes = cast("JsonTable", require_entry(request, "changes", dict, {}))
    text = _remove_entries(text, require_entry(request, "removed", list, []))
    kinds = [path for path in changes if path == MATERIAL or path.endswith(".kind")]
    rest = {path: value for path, value in changes.items() if path not in kinds}
    if not kinds:
        return _describe_form(
            read_request_scenario({"text": text, "changes": rest}, desk), ChangedScenario({})
        )
    notes: list[str] = []
    assumed: list[str] = []
    for path in kinds:
        scenario = read_request_scenario({"text": text}, desk)
        found = change_kind(scenario, path, str(changes[path]), rest)
        if found.missing:
            return _describe_missing(found)
        text, notes, assumed = as_toml(found.document), notes + found.notes, assumed + found.assumed
    return _describe_form(
        read_request_scenario({"text": text}, desk), ChangedScenario({}, notes, assumed)
    )


def _remove_entries(text: str, removed: list[Any]) -> str:
    """The document without some entries."""
    if not removed:
        return text
    document = toml_document(text)
    for path in removed:
        if not isinstance(path, str):
            raise BadMessageError("`removed` must be a list of texts.")
        documents.remove_entry(document, path)
    return as_toml(document)


def _describe_form(scenario: Scenario, found: ChangedScenario) -> JsonTable:
    return {
        "text": scenario.text,
        "title": scenario.title,
        "sections": [_strip_private(one) for one in FormSections(scenario).all()],
        "registries": list_choices(),
        "notes": found.notes,
        "assumed": found.assumed,
        "missing": [],
    }


def _describe_missing(found: ChangedScenario) -> JsonTable:
    """What is still needed."""
    names = ", ".join(f"`{one.name}` ({one.declared.doc})" for one in found.missing)
    owner = found.missing[0].owner
    return {
        "text": None,
        "refused": f"`{owner}` needs {names}: there is no start value, and the material has none.",
        "missing": [_build_control(one) for one in found.missing],
    }


def _build_control(one: MissingNumber) -> Control:
    """The control of what is missing; one for a number is empty."""
    spot = EntrySpot(one.path, one.name, one.declared, "none")
    if one.declared.kind == "option":
        return controls.describe_option(spot, "")
    if one.declared.kind == "text":
        return controls.describe_text(spot, "")
    return controls.describe_number(spot, None, one.unit)


def _strip_private(control: Control) -> Control:
    """A control without what is only for the server."""
    kept = {key: value for key, value in control.items() if not key.startswith("_")}
    if "items" in kept:
        kept["items"] = [_strip_private(one) for one in kept["items"]]
    return kept


@cache
def _list_choices(kind: str, names: tuple[str, ...]) -> list[dict[str, str]]:
    registry = list_registries()[kind]
    return [{"name": name, "summary": summarise_class(registry[name])} for name in names]


def list_choices() -> dict[str, list[dict[str, str]]]:
    """Everything that can be chosen, by the word for the entries of its registry."""
    known = list_registries().items()
    return {kind: _list_choices(kind, tuple(registry.names())) for kind, registry in known}
