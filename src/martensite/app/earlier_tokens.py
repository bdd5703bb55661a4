"""Tokens of earlier starts on a port, so that an open tab continues after a restart of the server.

Each start makes a new token. Its digest is stored in the user's cache folder; it recognises a cookie of an earlier
start on the same port, which is exchanged for the new one. The last port is also stored, because pages store their
work by address.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from martensite.base.caches import cache_folder, is_private_file, keep_private, make_private_folder

FIRST_OPEN_PORT = 1024
"""Ports below this one need administrator rights, and are named explicitly."""
LONGEST_KEPT = 30 * 86400.0
"""Seconds after its start for which a token is recognised."""
MOST_KEPT = 8
"""Stored starts per port."""
_PORT_KEPT = "port"


def digest_token(token: str) -> str:
    """Return the digest of a token, from which the token cannot be recovered."""
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()


@dataclass(frozen=True)
class TokenRecord:
    """Record of earlier starts; empty if the cache folder cannot be used."""

    folder: Path

    @classmethod
    def of_user(cls) -> TokenRecord:
        """Return the record in the user's cache folder."""
        return cls(cache_folder() / "app")

    def list_earlier(self, port: int) -> frozenset[str]:
        """Return the digests of recent tokens of earlier starts on a port."""
        return frozenset(digest for digest, _ in self._read_starts(port))

    def find_port(self) -> int:
        """Return the last port; 0 without a usable one."""
        port = self._read(_PORT_KEPT)
        return port if isinstance(port, int) and FIRST_OPEN_PORT <= port <= 65535 else 0

    def add_start(self, port: int, token: str) -> None:
        """Store a start."""
        starts = [*self._read_starts(port), (digest_token(token), time.time())]
        self._write(str(port), starts[-MOST_KEPT:])
        self._write(_PORT_KEPT, port)

    def _read_starts(self, port: int) -> list[tuple[str, float]]:
        text = self._read(str(port))
        rows = cast("list[Any]", text) if isinstance(text, list) else []
        oldest = time.time() - LONGEST_KEPT
        with suppress(TypeError, ValueError):
            return [(str(digest), float(began)) for digest, began in rows if float(began) > oldest]
        return []

    def _read(self, name: str) -> Any:
        """Return the content of a file of the record; None if it is missing or writable by others."""
        path = self.folder / f"{name}.json"
        with suppress(OSError, ValueError):
            return json.loads(path.read_text(encoding="utf-8")) if is_private_file(path) else None
        return None

    def _write(self, name: str, content: Any) -> None:
        with suppress(OSError):
            make_private_folder(self.folder)
            new_path = self.folder / f"{name}.{os.getpid()}.new"
            with suppress(FileNotFoundError):
                new_path.unlink()
            with os.fdopen(
                os.open(new_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8"
            ) as file:
                json.dump(content, file)
            keep_private(new_path, self.folder / f"{name}.json")
