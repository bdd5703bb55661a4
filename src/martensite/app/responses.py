"""Answers of the server: JSON, or the sentence of a refusal with its status."""

from __future__ import annotations

from typing import Any

from starlette.responses import Response

from martensite.app.messages import Refusal, Written, write_message


def json_response(content: Any, status: int = 200) -> Response:
    """An answer in JSON."""
    body = content if isinstance(content, Written) else write_message(content)
    return Response(body, status, media_type="application/json")


def refusal_response(refusal: Refusal, quiet: bool = False) -> Response:
    """A refusal: its sentence, and how the page shall take it; its status in a header if quiet."""
    content = {"error": str(refusal), "kind": refusal.kind}
    if not quiet:
        return json_response(content, refusal.status)
    response = json_response(content)
    response.headers["X-Refused"] = str(refusal.status)
    return response
