"""Model of the log of a board: the scenario inside it without its loop, and the parameters that the log determines.

`martensite fit LOG` uses it without a scenario, so that such a log is read without options.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.base.toml_text import as_toml
from martensite.boards.board_log import ENDINGS, read_log_scenario
from martensite.fit.api import build_task
from martensite.logs.reader import read_log_table
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.scenario.sections import SECTIONS

USUAL = ("h", "A_s", "A_f", "M_s", "M_f")
"""Free parameters of a wire by default, if the log determines them."""
SILENT = 1e-3
"""Influence on the measurements over the largest below which a log does not determine a parameter."""


def write_rig_scenario(text: str) -> str:
    """Return an open-loop copy of a scenario; its drive follows the column `duty` of a log.

    Raises:
        DataError: the text is no TOML.
    """
    try:
        document: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"The scenario in the log is damaged ({error}); give --scenario.") from None
    source = document.get("driver", {"kind": "pwm-voltage"})
    followed = {"waveform": {"kind": "log", "column": "duty", "between": "hold"}}
    sections = {name: section for name, section in document.items() if name not in (*SECTIONS, "driver", "run")}
    return as_toml(sections | {"drive": {**source, **followed}})


def read_rigs(logs: Sequence[str], free: Sequence[str] | None = None) -> tuple[list[Scenario], list[str]] | None:
    """Return scenarios for logs, and their free parameters: given, or the usual ones that the logs determine.

    None if a log has no scenario.
    """
    texts = [_read_carried(Path(one)) for one in logs]
    if not texts or not all(texts):
        return None
    rigs = [
        read_scenario(write_rig_scenario(text), log=read_log_table(one)) for text, one in zip(texts, logs, strict=True)
    ]
    return rigs, list(free or choose_free(rigs, logs))


def _read_carried(path: Path) -> str:
    return read_log_scenario(path) if path.suffix.lower() in ENDINGS and path.is_file() else ""


def choose_free(rigs: Sequence[Scenario], logs: Sequence[str]) -> list[str]:
    """Return the usual parameters that logs determine, by the slopes of the model at the start.

    Raises:
        ParameterError: the logs determine none of them.
    """
    there = {leaf.path.rpartition(".")[2] for rig in rigs for leaf in rig.system.leaves()}
    names = [name for name in USUAL if name in there]
    problem = build_task(rigs, list(logs), names).arrange(check=False).problem.training
    evaluation = problem.evaluate(problem.start, slopes=True)
    influence = np.zeros(len(names)) if evaluation is None else np.linalg.norm(evaluation.jacobian, axis=0)
    determined = [name for name, size in zip(names, influence, strict=True) if size > SILENT * max(influence)]
    if not determined:
        raise ParameterError("The logs determine no parameter of the wire. Choose parameters by --free.")
    return determined
