"""The route table: function by name of the call.

A function of a request and a `Desk` returns JSON. Modules are imported at their first call, since some take a second.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from martensite.app.messages import Request
from martensite.base.errors import require_known

if TYPE_CHECKING:
    from martensite.app.worker import Desk

CALLS = "martensite.app.calls"
ROUTES: Mapping[str, tuple[str, str]] = {
    # the bench
    "run": ("scenarios", "run_scenario"),
    "form": ("form", "build_form"),
    "scenarios": ("scenarios", "list_scenarios"),
    "differences": ("scenarios", "compare_documents"),
    "export": ("scenarios", "export_scenario"),
    "model": ("models", "build_model"),
    # fits
    "sample_log": ("logs", "place_sample"),
    "table": ("logs", "describe_table"),
    "fit_records": ("logs", "describe_records"),
    "log_overlay": ("logs", "overlay_logs"),
    "fit_proposal": ("logs", "propose_fit"),
    "fit_starts": ("logs", "list_followers"),
    "fit_scenario": ("logs", "match_scenario"),
    "fit": ("fits", "run_fit"),
    "fit_files": ("fits", "write_fit_file"),
    # boards
    "boards": ("boards", "describe_boards"),
    "board_firmware": ("boards", "write_board_firmware"),
    "board_run": ("boards", "run_board"),
    # sizing
    "size_form": ("sizing", "describe_sizing"),
    "size": ("sizing", "size_wires"),
    "size_map": ("size_map", "map_wishes"),
    "size_catalogue": ("sizing", "compare_catalogue"),
    # studies
    "studies": ("studies", "list_studies"),
    "study_page": ("studies", "describe_study_page"),
    "study_figure": ("studies", "read_figure"),
    "study": ("studies", "compute_study"),
    # sweeps
    "sweep_form": ("sweep_form", "describe_sweep_form"),
    "sweep_plan": ("sweeps", "plan_sweep"),
    "sweep_time": ("sweeps", "estimate_time"),
    "sweep": ("sweeps", "run_sweep"),
    "sweeps": ("sweeps", "list_sweeps"),
    "sweep_points": ("sweeps", "read_points"),
    "sweep_row": ("sweeps", "read_row"),
    "sweep_front": ("sweeps", "find_front"),
    "sweep_indices": ("sweeps", "estimate_indices"),
    "sweep_delete": ("sweeps", "delete_sweep"),
    "sweep_export": ("sweep_form", "export_sweep"),
}
"""Module of `martensite.app.calls`, and function, by name."""


def find_call(name: str) -> Callable[[Request, Desk], Any]:
    """Return the function of a call."""
    require_known("call", name, ROUTES)
    module, function = ROUTES[name]
    return getattr(import_module(f"{CALLS}.{module}"), function)
