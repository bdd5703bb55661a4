"""Access to the server: only this machine's browser, from the server's own page, with its token.

A request must have the server's address (header Host: no DNS rebinding), come from its own page or from no page
(Origin, Sec-Fetch-Site), and have the token of this run: in a cookie, which the address with `?token=` sets, or as
`Authorization: Bearer`. A cookie of an earlier start on this port is exchanged (`earlier_tokens`). A connection without
a request within `REQUEST_WAIT` is closed; otherwise clients without a token could exhaust sockets.
"""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from martensite.app.earlier_tokens import digest_token
from martensite.app.messages import COLUMNS_TYPE, PackedColumns, Refusal, WorkerJson, write_message

POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' ws://{host}; font-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy: only the scripts of the page; figures contain inline styles."""
HEADERS: Mapping[str, str] = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
REQUEST_WAIT = 10.0
"""Time from a connection, or the first byte of a further request, to the end of its headers [s]."""
NAMES = ("127.0.0.1", "localhost")
TOKEN_ONCE = ("host", "origin", "authorization", "cookie", "sec-fetch-site", "sec-fetch-mode")
"""Headers that can occur only once, against different readings."""
STRANGER = "This page needs the token of the running bench: open the address that `martensite app` printed."


class TimedProtocol(H11Protocol):
    """HTTP protocol that closes connections without complete headers in time."""

    _waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start the timeout of the first request."""
        super().connection_made(transport)
        self._await_request()

    def data_received(self, data: bytes) -> None:
        """Stop the timeout after a full request; other bytes do not prolong it."""
        super().data_received(data)
        self._await_request()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the timeout."""
        super().connection_lost(exc)
        self._stop_waiting()

    def _await_request(self) -> None:
        answering = self.cycle is not None and not self.cycle.response_complete
        left = self.transport.is_closing() or self.transport.get_protocol() is not self  # as for a web socket
        if answering or left:
            self._stop_waiting()
        elif self._waiting is None:
            self._waiting = self.loop.call_later(REQUEST_WAIT, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None


@dataclass(frozen=True)
class RequestGuard:
    """ASGI middleware that refuses unauthorised requests."""

    app: ASGIApp
    token: str
    port: int
    earlier: frozenset[str] = frozenset()
    """Digests of the tokens of earlier starts, whose cookies are exchanged."""

    @property
    def cookie(self) -> str:
        """Return the name of the cookie; all ports of a machine share cookies."""
        return f"martensite-{self.port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        try:
            host = self._answer_place(scope)
            entered = self._let_in(scope)
            renewed = self._renew_cookie(scope) if entered is None else None
        except Refusal as refusal:
            sending = _with_headers(send, f"{NAMES[0]}:{self.port}")
            await _refuse(scope, receive, sending, refusal)
            return
        await (entered or self.app)(scope, receive, _with_headers(send, host, renewed))

    def _answer_place(self, scope: Scope) -> str:
        """Return the host of a request; refuse other hosts and origins."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if host not in [f"{name}:{self.port}" for name in NAMES]:
            raise Refusal("This server answers to its own address on this machine only.", 421)
        doubled = next((name for name in TOKEN_ONCE if len(headers.getlist(name)) > 1), None)
        if doubled is not None:
            raise Refusal(f"There must be one header `{doubled}`.")
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{host}":
            raise Refusal(f"Pages of `{origin[:80]}` may not use this server.", 403)
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            navigated = headers.get("sec-fetch-mode") == "navigate" and scope["path"] == "/"
            if not navigated:
                raise Refusal("Other pages may not use this server.", 403)
        return host

    def _renew_cookie(self, scope: Scope) -> str | None:
        """Return the new cookie for a token of an earlier start, else None; refuse other tokens."""
        headers = Headers(scope=scope)
        scheme, _, given = headers.get("authorization", "").partition(" ")
        bearer = scheme.lower() == "bearer"
        token = given if bearer else _read_cookie(headers, self.cookie)
        if self._is_right(token):
            return None
        if bearer or scope["type"] != "http" or digest_token(token) not in self.earlier:
            raise Refusal(STRANGER, 401)
        answer = Response()
        self._set_cookie(answer)
        return answer.headers["set-cookie"]

    def _is_right(self, token: str) -> bool:
        return hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode())

    def _let_in(self, scope: Scope) -> Response | None:
        """Return the redirect of an address with the token, which sets the cookie."""
        if scope["type"] != "http" or scope["path"] != "/" or scope["method"] != "GET":
            return None
        tokens = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
        if not tokens or not self._is_right(tokens[0]):
            return None
        response = RedirectResponse("/", 303)
        self._set_cookie(response)
        return response

    def _set_cookie(self, response: Response) -> None:
        # lax: the first page may be opened from elsewhere, such as a terminal in a browser;
        # Sec-Fetch-Site and Origin refuse other foreign requests
        response.set_cookie(self.cookie, self.token, httponly=True, samesite="lax")


def _read_cookie(headers: Headers, name: str) -> str:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return ""
    return "" if cookie is None else cookie.value


def _with_headers(send: Send, host: str, cookie: str | None = None) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers["Content-Security-Policy"] = POLICY.format(host=host)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
            if cookie is not None:
                headers.append("Set-Cookie", cookie)
        await send(message)

    return sending


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: Refusal) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 4403, "reason": str(refusal)[:120]})
        return
    words = PlainTextResponse(str(refusal), refusal.status)
    response = words if scope["path"] == "/" else refusal_response(refusal)
    await response(scope, receive, send)


def json_response(content: Any, status: int = 200) -> Response:
    """Return a JSON answer, or packed columns."""
    if isinstance(content, PackedColumns):
        return Response(content, status, media_type=COLUMNS_TYPE)
    body = content if isinstance(content, WorkerJson) else write_message(content)
    return Response(body, status, media_type="application/json")


def refusal_response(refusal: Refusal, quiet: bool = False) -> Response:
    """Return a refusal with sentence and kind; if quiet, its status is in a header."""
    content = {"error": str(refusal), "kind": refusal.kind}
    if not quiet:
        return json_response(content, refusal.status)
    response = json_response(content)
    response.headers["X-Refused"] = str(refusal.status)
    return response
