"""`export c`: a scenario as C99 for microcontrollers, with an example that plays its drive."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.export import export
from martensite.cli.options import Force, Json, ScenarioSource, Text, spread_options
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.export.c_core import CCore
    from martensite.scenario.scenario import Scenario

PARTS = ("whole", "plant", "loop")
STEPS = 400
"""That the example plays at least."""


@export.command("c")
@spread_options
def c(
    source: ScenarioSource,
    out: Annotated[Path, Option(metavar="FOLDER", help="Where to write.")] = Path(),
    name: Annotated[Text, Option(help="Name of the files and in them [default: SCENARIO].")] = None,
    part: Annotated[
        str,
        Option(
            help="whole; plant: without the loops around it; loop: observers, controllers and "
            "supervisor without the plant, for a controller board."
        ),
    ] = "whole",
    precision: Annotated[str, Option(help="float64 (double), or float32 (float).")] = "float64",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as C99: header, source, and an example that plays its drive.

    No allocation, no library but libm; in double the results are those of `run`, bit for bit.
    Operations are counted at worst: what is not chosen in a step is not computed.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import checked_identifier, make_identifier
    from martensite.show.terminal import print_summary

    if part not in PARTS:
        raise ParameterError(f"There is no part `{part}`. {suggest_name(part, PARTS)}")
    name = checked_identifier(name or make_identifier(source.file.stem))
    files = _check_files(out, name, force)
    core, example, tried = _make_core(source.load(), name, part, precision)
    make_folder(out)
    with replace_together():
        core.write(out)
        write_file(files[-1], example)
    print_summary(_summarise_core(core, part, tried), json, files)


def _check_files(folder: Path, name: str, force: bool) -> list[Path]:
    """The files that will be written; `DataError` if one is there already.

    The folder is made if it is missing, but not what it is in.
    """
    files = [folder / f"{name}{end}" for end in (".h", ".c", "_example.c")]
    missing = not folder.exists()
    for path in [folder.parent / files[1].name] if missing else files:
        Outputs(path, None).check(force or missing, data=(".h", ".c"))
    return files


def _make_core(loaded: Scenario, name: str, part: str, precision: str) -> tuple[CCore, str, str]:
    """The core of a part of a scenario, the text of its example, and how far it was tried."""
    from martensite.export.c_core import build_c_core, build_c_loop
    from martensite.export.c_example import (
        MOST,
        MOST_TRIED,
        example_text,
        played_by_loop,
        played_by_system,
        try_program,
    )

    if loaded.outside and part != "plant":
        kind = next(iter(loaded.outside.values())).registered_name
        raise ParameterError(
            f"The controller `{kind}` is no kernel and cannot be written as C; the plant alone can: `--part plant`."
        )
    if part != "loop":
        system = loaded.system if part == "plant" else loaded.whole
        core = build_c_core(system, name=name, precision=precision)
        play = partial(played_by_system, system, loaded.waveform, loaded.duration, STEPS)
    elif loaded.bench is None:
        raise ParameterError("This scenario has no loop: there is no controller in it.")
    else:
        core = build_c_loop(loaded.bench, name=name, precision=precision)
        play = partial(played_by_loop, loaded.bench, loaded.waveform, loaded.run(), STEPS)
    tried = try_program(core, play(MOST_TRIED)) if core.precision == "float32" else ""
    return core, example_text(core, *play(MOST)), tried


def _summarise_core(core: CCore, part: str, tried: str) -> Summary:
    """What was written, and how many operations every call takes at most."""
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
        [call, str(sum(found.values())), *(str(found.get(kind, 0)) for kind in kinds)]
        for call, found in core.operations.items()
    ]
    head = ["operations at most", "sum", *kinds]
    blocks = [
        Sentence(f"{core.description}, {core.precision}"),
        Sentence(f"model: {core.size:,} bytes ({numbers})"),
        DataTable(head, rows, right=range(1, len(head))),
        *([Sentence(tried)] if tried else []),
    ]
    return Summary("", blocks, data)
