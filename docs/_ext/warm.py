"""What the processes of pages and of their commands share: done once, before they begin.

Modules are imported, the tree of commands is built, a command reads units and writes a table, and a figure is
drawn. Nothing here starts a thread: a process must not be copied once threads run in it.
"""

from __future__ import annotations

import functools
import gc
import importlib
import io
import pkgutil
from contextlib import suppress

import h5netcdf  # noqa: F401
import IPython.core.application
import IPython.core.completerlib
import IPython.core.magics.execution
import IPython.core.magics.pylab  # noqa: F401
import matplotlib.pyplot as plt
import matplotlib_inline.backend_inline  # noqa: F401
import processes  # noqa: F401
import scipy.optimize
import scipy.signal  # noqa: F401
import typer.main
import xarray  # noqa: F401
import zarr  # noqa: F401
from matplotlib.backends.registry import backend_registry
from typer.testing import CliRunner

from martensite.cli import app

OTHERS = ("control", "dask", "fmu", "gymnasium", "mujoco")
"""What only some pages need; they import it themselves."""


def _import_all(package: str) -> None:
    """Import every module of a package but those that need one of the others."""
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        if not module.name.endswith(("__main__", *OTHERS)):
            with suppress(ImportError):  # of an extra that is not installed
                importlib.import_module(module.name)


def _draw() -> None:
    """Draw a figure: fonts are found once."""
    figure, axes = plt.subplots()
    axes.plot([0.0, 1.0])
    axes.set_xlabel(r"$\sigma$")
    figure.savefig(io.BytesIO(), format="svg")
    plt.close(figure)


for name in ("dask.array", "distributed"):  # xarray imports them to open and to load a sweep
    with suppress(ImportError):
        importlib.import_module(name)
_import_all("martensite")
typer.main.get_command = functools.cache(typer.main.get_command)
typer.main.get_command(app)
backend_registry.resolve_backend("inline")  # looks through all installed packages
CliRunner().invoke(app, ["materials", "copaci-2019"])
_draw()
gc.freeze()
gc.set_threshold(20_000, 20, 25)  # traced graphs are full of cycles, looked for too often
