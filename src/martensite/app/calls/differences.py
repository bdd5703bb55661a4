"""What differs between documents.

{"texts": [TOML, TOML, …]} -> {"rows": [{"path": "element.diameter", "values": ["0.2 mm", null]}]}
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

from martensite.app.documents import LONGEST
from martensite.app.messages import BadMessageError, wanted
from martensite.app.worker import Desk
from martensite.base.files import toml_document
from martensite.scenario.overrides import toml_value

MOST = 12
"""Documents that are compared at once."""


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Paths whose values are not the same in all documents, in the order of the first."""
    texts = wanted(request, "texts", list)
    if len(texts) > MOST or not all(isinstance(t, str) and len(t) <= LONGEST for t in texts):
        raise BadMessageError(f"`texts` must be at most {MOST} documents, each a text.")
    documents = [dict(_flat(toml_document(text, "A document"))) for text in texts]
    paths = dict.fromkeys(path for document in documents for path in document)
    rows = [{"path": path, "values": [d.get(path) for d in documents]} for path in paths]
    return {"rows": [row for row in rows if any(v != row["values"][0] for v in row["values"])]}


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Dotted path and value, as it is written, of every entry."""
    for key, value in table.items():
        path = f"{above}{key}"
        if isinstance(value, dict):
            yield from _flat(cast("dict[str, Any]", value), f"{path}.")
        else:
            yield path, value if isinstance(value, str) else toml_value(value)
