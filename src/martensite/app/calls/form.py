"""The form of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

from martensite.app.documents import NEW, read_request_scenario
from martensite.app.forms import controls, documents
from martensite.app.forms.controls import EntrySpot
from martensite.app.forms.form_types import MissingNumbers, ScenarioForm, SingleNode
from martensite.app.forms.kind_change import change_kind
from martensite.app.forms.sections import MATERIAL, describe_scenario
from martensite.app.forms.table_filler import MissingNumber
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.worker import Desk
from martensite.base.files import toml_document
from martensite.base.toml_text import as_toml


def build_form(request: Request, desk: Desk) -> ScenarioForm:
    """Return the form of a scenario, a control for each entry (`forms.form_types`).

    {"text": TOML, "changes": {path: value}, "removed": [path]} -> `ScenarioForm`

    An empty text is a new scenario. A change of `element.material`, or of a path that ends in `.kind`, adapts the rest
    of the document (`forms.kind_change`). If a kind needs unknown values, the form is of the unchanged scenario, `text`
    is null, `refused` a sentence, and `missing` their controls; the next request repeats the changes with these values.
    """
    text = require_entry(request, "text", str, "") or NEW.read_text("utf-8")
    changes = cast("JsonTable", require_entry(request, "changes", dict, {}))
    text = _remove_entries(text, require_entry(request, "removed", list, []))
    kinds = [path for path in changes if path == MATERIAL or path.endswith(".kind")]
    rest = {path: value for path, value in changes.items() if path not in kinds}
    if not kinds:
        return describe_scenario(read_request_scenario({"text": text, "changes": rest}, desk))
    notes: list[str] = []
    assumed: list[str] = []
    for path in kinds:
        scenario = read_request_scenario({"text": text}, desk)
        changed = change_kind(scenario, path, str(changes[path]), rest)
        if changed.missing:
            return {**describe_scenario(scenario), **_describe_missing(changed.missing)}
        text, notes, assumed = as_toml(changed.document), notes + changed.notes, assumed + changed.assumed
    form = describe_scenario(read_request_scenario({"text": text}, desk))
    return {**form, "notes": notes, "assumed": assumed}


def _remove_entries(text: str, removed: list[Any]) -> str:
    if not removed:
        return text
    document = toml_document(text)
    for path in removed:
        if not isinstance(path, str):
            raise BadMessageError("`removed` must be a list of texts.")
        documents.remove_entry(document, path)
    return as_toml(document)


def _describe_missing(missing: Sequence[MissingNumber]) -> MissingNumbers:
    names = ", ".join(f"`{one.name}` ({one.declared.doc})" for one in missing)
    sentence = f"`{missing[0].owner}` needs {names}: there is no start value, and the material has none."
    return {"text": None, "refused": sentence, "missing": [_build_control(one) for one in missing]}


def _build_control(one: MissingNumber) -> SingleNode:
    spot = EntrySpot(one.path, one.name, one.declared, "none")
    if one.declared.kind == "option":
        return controls.describe_option(spot, "")
    if one.declared.kind == "text":
        return controls.describe_text(spot, "")
    return controls.describe_number(spot, None, one.unit)
