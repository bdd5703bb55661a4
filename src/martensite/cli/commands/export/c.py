"""`export c`: a scenario as C99, with an example."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import InputError, ParameterError, require_known
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.commands.export import export
from martensite.cli.material_options import Port, write_core_alone
from martensite.cli.options import Force, Json, ScenarioSource, Text, spread_options
from martensite.cli.outputs import check_folder_files

if TYPE_CHECKING:
    from martensite.export.c_core import CCore
    from martensite.scenario.scenario import Scenario

PARTS = ("whole", "plant", "loop")
ALONE = ("element", "material")
EXAMPLE_STEPS = 400
"""Smallest number of steps of the example."""


@export.command("c")
@spread_options
def c(
    source: ScenarioSource,
    out: Annotated[Path, Option(metavar="FOLDER", help="Output folder.")] = Path(),
    name: Annotated[Text, Option(help="Prefix of file and function names [default: SCENARIO].")] = None,
    part: Annotated[
        str,
        Option(
            help=(
                "Exported part: whole (loop and plant), plant, loop (controllers, for a board), element or "
                "material (for a host)."
            )
        ),
    ] = "whole",
    port: Port = None,
    precision: Annotated[str, Option(help="Floating-point type: float64 or float32.")] = "float64",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as C99: header, source and example.

    The code needs no allocation and only libm. With float64 the results equal those of `run` bit for bit. The
    report counts the operations of the worst case.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import choose_identifier
    from martensite.show.terminal import print_summary

    require_known("part", part, (*PARTS, *ALONE))
    if port is not None and part not in ALONE:
        raise InputError(f"Option `--port` goes with `--part element` or `--part material`, not with `{part}`.")
    name = choose_identifier(name, source.file.stem)
    ends = (".h", ".c") if part in ALONE else (".h", ".c", "_example.c")
    files = check_folder_files(out, [f"{name}{end}" for end in ends], force)
    core, example, tried = _make_core(source.load(), name, part, precision, port)
    make_folder(out)
    with replace_together():
        core.write(out)
        if example:
            write_file(files[-1], example)
    print_summary(_summarise_core(core, part, tried), json, files)


def _make_core(loaded: Scenario, name: str, part: str, precision: str, port: str | None) -> tuple[CCore, str, str]:
    if part in ALONE:
        return write_core_alone(loaded.system, part, port, name, precision), "", ""
    from martensite.export.c_core import build_c_core, build_c_loop
    from martensite.export.c_example import (
        MOST,
        MOST_TRIED,
        example_text,
        list_loop_inputs,
        list_run_inputs,
        try_program,
    )

    if part != "loop":
        system = loaded.system if part == "plant" else loaded.whole
        core = build_c_core(system, name=name, precision=precision)
        play = partial(list_run_inputs, system, loaded.waveform, loaded.duration, EXAMPLE_STEPS)
    elif loaded.bench is None:
        raise ParameterError("This scenario has no loop: there is no controller in it.")
    else:
        core = build_c_loop(loaded.bench, name=name, precision=precision)
        play = partial(list_loop_inputs, loaded.bench, loaded.waveform, loaded.run(), EXAMPLE_STEPS)
    tried = try_program(core, play(MOST_TRIED)) if core.precision == "float32" else ""
    return core, example_text(core, *play(MOST)), tried


def _summarise_core(core: CCore, part: str, tried: str) -> Summary:
    from martensite.export.c_kernels import ORDER

    counts = {
        "parameters": len(core.parameters),
        "constants": core.constants,
        "states": core.states,
        "inputs": len(core.inputs),
        "outputs": len(core.outputs),
    }
    data = {
        "name": core.name,
        "part": part,
        "described": core.description,
        "precision": core.precision,
        "model_bytes": core.size,
        **counts,
        "sample_time": core.sample_time,
        "operations": core.operations,
        "tried": tried or None,
    }
    numbers = ", ".join(f"{kind} {count}" for kind, count in counts.items())
    kinds = [kind for kind in ORDER if any(kind in one for one in core.operations.values())]
    rows = [
        [call, str(sum(tally.values())), *(str(tally.get(kind, 0)) for kind in kinds)]
        for call, tally in core.operations.items()
    ]
    blocks = [
        Sentence(f"{core.description}, {core.precision}"),
        Sentence(f"model: {core.size:,} bytes ({numbers})"),
        DataTable(("operations at most", "sum", *kinds), rows, right=range(1, len(kinds) + 2)),
        *([Sentence(tried)] if tried else []),
    ]
    return Summary("", blocks, data)
