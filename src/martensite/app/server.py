"""Server on loopback with a new token, until it is interrupted."""

from __future__ import annotations

import secrets
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from martensite.app.earlier_tokens import TokenRecord
from martensite.base.errors import InputError

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True)
class ServerAddress:
    """Address of a running server."""

    port: int
    token: str

    @property
    def address(self) -> str:
        """Return the address for a browser, which includes the token."""
        return f"http://{LOOPBACK}:{self.port}/?token={self.token}"


def bind_socket(port: int) -> socket.socket:
    """Return a socket on loopback; port 0 is any free one."""
    if not 0 <= port <= 65535:
        raise InputError(f"Option `--port` must be between 0 and 65535, but is {port}.")
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform == "win32":  # reuse would let other processes take it over
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((LOOPBACK, port))
    except OSError as error:
        listener.close()
        raise InputError(f"Port {port} cannot be used ({error.strerror}); leave `--port` out for a free one.") from None
    return listener


def bind_usual_port(port: int, record: TokenRecord) -> socket.socket:
    """Return a socket on the port; port 0 prefers the last one, since pages store their work by address."""
    usual = record.find_port() if port == 0 else 0
    with suppress(InputError):
        if usual:
            return bind_socket(usual)
    return bind_socket(port)


def make_folder(folder: Path) -> Path:
    """Return the folder of files, created if missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"`{folder}` cannot be the folder of the bench ({error.strerror}).") from None
    return folder.resolve()


def serve_bench(
    port: int = 0, folder: Path | None = None, ready: Callable[[ServerAddress], None] = lambda at: None
) -> None:
    """Serve the bench until it is interrupted (Ctrl-C, SIGTERM, SIGHUP).

    Args:
        port: port on loopback; 0 for the last one, or else a free one.
        folder: folder of uploaded files and sweeps; by default temporary.
        ready: called with the address before the first request.
    """
    import uvicorn

    from martensite.app.request_guard import TimedProtocol
    from martensite.app.site import STATIC, build_site

    if not (STATIC / "index.html").is_file():
        raise InputError(f"The page of the bench is not in `{STATIC}`; build it: `npm run build` in `web`.")
    with ExitStack() as stack:
        stack.enter_context(_end_on_signals())
        if folder is None:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="martensite-")))
        folder, record = make_folder(folder), TokenRecord.of_user()
        opened = stack.enter_context(bind_usual_port(port, record))
        at = ServerAddress(opened.getsockname()[1], secrets.token_urlsafe(24))
        earlier = record.list_earlier(at.port)
        record.add_start(at.port, at.token)
        config = uvicorn.Config(
            build_site(folder, at.token, at.port, earlier),
            log_level="warning",
            access_log=False,
            http=TimedProtocol,
            ws="websockets-sansio",
            ws_max_size=2**16,
            timeout_graceful_shutdown=2,
            server_header=False,
            proxy_headers=False,
            lifespan="on",
        )
        server = uvicorn.Server(config)
        if hasattr(signal, "SIGHUP") and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGHUP, server.handle_exit)
        opened.listen(64)
        ready(at)
        server.run(sockets=[opened])


@contextmanager
def _end_on_signals() -> Iterator[None]:
    """Convert signals that end the server to one exception, for a clean shutdown.

    While it runs, the server handles SIGINT and SIGTERM itself, and raises them at its end.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    names = ("SIGINT", "SIGTERM", "SIGHUP")
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = {number: signal.signal(number, _end_server) for number in numbers}
    try:
        with suppress(_Ended):
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Ended(SystemExit):
    """A signal to end the server."""


def _end_server(number: int, frame: Any) -> None:
    raise _Ended
