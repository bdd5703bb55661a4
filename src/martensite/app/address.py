"""The state of the bench in its address: the text of a scenario, deflated, behind the `#`.

What stands behind the `#` never leaves the browser.
"""

from __future__ import annotations

import base64
import zlib


def pack_text(text: str) -> str:
    """A text as letters that may stand in an address."""
    made = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = made.compress(text.encode()) + made.flush()
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def unpack_text(letters: str) -> str:
    """The text of such letters."""
    data = base64.urlsafe_b64decode(letters + "=" * (-len(letters) % 4))
    return zlib.decompress(data, -15).decode()


def build_address(address: str, text: str) -> str:
    """The address of a bench that begins with a scenario."""
    return f"{address}#/bench?scenario={pack_text(text)}"
