"""Model and simulate shape-memory-alloy actuators.

    import martensite as ms
    result = ms.run("finger.toml")
    result["position"], result.plot()

The names in the stub of this package, and those of `ms.laws`, `ms.elements`, `ms.control`,
`ms.fit`, …, are what is promised to stay. They are imported when they are first used, so that
`import martensite` costs nothing.
"""

from __future__ import annotations

from typing import Any

from martensite.base.lazy import attach_names
from martensite.base.services import offer_services

_import_name, __dir__ = attach_names(__name__)
offer_services(
    {
        "render_html": "martensite.show.html:render_fragment",
        "plot_run": "martensite.show.figures.overview:plot_result",
        "save_run_figure": "martensite.show.figures.overview:save_figure",
        "save_run": "martensite.scenario.saved_results:save_by_suffix",
        "describe_run": "martensite.scenario.netcdf:describe_result",
        "make_bench_widget": "martensite.app.notebook:BenchWidget",
    }
)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    return _read_version() if name == "__version__" else _import_name(name)


def _read_version() -> str:
    """The version that is installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("martensite")
    except PackageNotFoundError:  # run from a source tree that was not installed
        return "0+unknown"
