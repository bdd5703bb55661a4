"""C of the elements of a MuJoCo model: each kernel once, tables of the elements, and `mujoco_callback.c`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from martensite.base.errors import InputError
from martensite.export.c_kernels import CKernel, kernels_text, precision_of
from martensite.export.mujoco_models import load_mujoco
from martensite.kernels.compiler import load_library
from martensite.simulate.compiled import CompiledSystem

NUMBERS = {"SOLVED": 1e-8, "AGREED": 1e-10, "LEAST": 1e-3, "TURNS": 50, "SWEEPS": 200, "MOST": 4096}
"""Residual of a solved element; relative change and smallest significant force [N] of balanced elements; iterations and
sweeps until then; groups of elements in a process.
"""


def list_flags() -> tuple[str, ...]:
    """Return the compiler flags that find the headers of MuJoCo."""
    return (f"-I{Path(load_mujoco().__file__).parent / 'include'}",)


def write_source(compiled: Sequence[CompiledSystem]) -> str:
    """Write the C of all elements of a model."""
    texts, kinds = list[str](), dict[int, int]()
    for one in compiled:
        if id(one.program) not in kinds:
            kinds[id(one.program)] = len(kinds)
            kernel = CKernel.of(one.program.functions["step"], one.size, 3)
            indices = list(range(len(one.program.parameters)))
            texts.append(
                kernels_text(one.program, indices, [kernel], f"k{kinds[id(one.program)]}_", precision_of("float64"))
            )
    numbers = NUMBERS | {
        "STRANDS": len(compiled),
        "KEPT": max(one.size for one in compiled),
        "CONSTANTS": max(1, *(one.program.constants for one in compiled)),
    }
    numbers_of_kinds = [kinds[id(one.program)] for one in compiled]
    tables = [
        f"#define STEPS ((const Kernel[]){{{', '.join(f'k{k}_kernel_step' for k in numbers_of_kinds)}}})",
        f"#define PREPARES ((const Prepare[]){{{', '.join(f'k{k}_kernel_prepare' for k in numbers_of_kinds)}}})",
        f"#define STATES ((const int[]){{{', '.join(str(one.size) for one in compiled)}}})",
    ]
    return "\n".join([*_define_numbers(numbers), *texts, *tables, _read_text("mujoco_callback.c")])


def _define_numbers(numbers: dict[str, Any]) -> list[str]:
    heads = ["float.h", "math.h", "stdlib.h", "string.h", "mujoco/mujoco.h"]
    return [*(f"#include <{name}>" for name in heads), *(f"#define {key} {value}" for key, value in numbers.items())]


def _read_text(name: str) -> str:
    return (Path(__file__).parent / name).read_text(encoding="utf-8")


@cache
def load_dispatcher() -> Any:
    """Return the library that MuJoCo calls back, loaded once per process."""
    mujoco = load_mujoco()
    if mujoco.get_mjcb_act_bias() is not None:
        raise InputError("MuJoCo's callback `mjcb_act_bias` is taken; set it to None first.")
    text = "\n".join([*_define_numbers({"MOST": NUMBERS["MOST"]}), _read_text("mujoco_dispatch.c")])
    library = load_library(text, list_flags())
    mujoco.set_mjcb_act_bias(library.find_bias)
    return library
