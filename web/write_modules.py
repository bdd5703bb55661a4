"""Compile the WebAssembly modules of all packaged and documented scenarios into the package: `make modules`.

It needs zig, the compiler of the extra `cc`.
"""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path

from martensite.app.documents import list_standalone
from martensite.app.static_site.packaged_modules import MODULES, write_modules
from martensite.base.errors import MartensiteError

ROOT = Path(__file__).resolve().parents[1]
FENCE = re.compile(r"^```toml\n(# wire\.toml\n.*?)^```$", re.DOTALL | re.MULTILINE)


def list_texts() -> list[str]:
    """Return the scenarios of the package, of its documentation, and of README.md."""
    sys.path.append(str(ROOT / "docs" / "_ext"))
    documented = import_module("make_site").list_documented()
    readme = (ROOT / "README.md").read_text("utf-8")
    return [*list_standalone().values(), *documented.values(), *FENCE.findall(readme)]


if __name__ == "__main__":
    try:
        written, deleted = write_modules(list_texts())
    except MartensiteError as error:
        sys.exit(f"make modules: {error}")
    size = sum(path.stat().st_size for path in MODULES.iterdir())
    sys.stdout.write(f"{MODULES}: {len(written)} modules compiled, {len(deleted)} deleted, {size / 1e6:.2f} MB\n")
