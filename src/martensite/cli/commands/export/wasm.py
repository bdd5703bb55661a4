"""`export wasm`: a scenario as WebAssembly."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import require_known
from martensite.base.summary import Sentence, Summary
from martensite.cli.commands.export import export
from martensite.cli.options import Force, Json, ScenarioSource, Text, spread_options
from martensite.cli.outputs import check_folder_files

if TYPE_CHECKING:
    from martensite.export.wasm import WasmModule
    from martensite.scenario.scenario import Scenario

PARTS = ("whole", "plant")
EXAMPLE_STEPS = 400
"""Smallest number of steps of the example in the guide."""


@export.command("wasm")
@spread_options
def wasm(
    source: ScenarioSource,
    out: Annotated[Path | None, Option(metavar="FOLDER", help="Output folder [default: ./SCENARIO_wasm].")] = None,
    name: Annotated[Text, Option(help="Prefix of file names [default: SCENARIO].")] = None,
    part: Annotated[str, Option(help="Exported part: whole (loop and plant) or plant.")] = "whole",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as WebAssembly for browsers and Node.js.

    The folder contains the module, a script with types, and a guide. The module has no imports and gives the
    results of `export c`. Compilation needs zig, for example from the extra `cc`.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import choose_identifier
    from martensite.export.wasm.module import find_wasm_compiler
    from martensite.show.terminal import print_summary

    require_known("part", part, PARTS)
    name = choose_identifier(name, source.file.stem)
    out = out or Path(f"{source.file.stem}_wasm")
    names = (f"{name}.wasm", f"{name}.js", f"{name}.d.ts", "README.md")
    files = check_folder_files(out, names, force)
    find_wasm_compiler()
    module = _make_module(source.load(), name, part)
    make_folder(out)
    with replace_together():
        for path in files:
            write_file(path, module.files[path.name])
    print_summary(_summarise_module(module), json, files)


def _make_module(loaded: Scenario, name: str, part: str) -> WasmModule:
    from martensite.export.c_example import list_run_inputs
    from martensite.export.wasm import build_wasm

    system = loaded.system if part == "plant" else loaded.whole
    first, _ = list_run_inputs(system, loaded.waveform, loaded.duration, EXAMPLE_STEPS)
    return build_wasm(system, name=name, title=loaded.title or name, first=first)


def _summarise_module(module: WasmModule) -> Summary:
    core = module.core
    data = {
        "name": core.name,
        "described": core.description,
        "module_bytes": len(module.binary),
        "packed_bytes": module.packed,
        "parameters": len(core.parameters),
        "states": core.states,
        "sample_time": core.sample_time,
        "signals": {one.name: one.unit for one in core.inputs},
        "outputs": {one.name: one.unit for one in core.outputs},
    }
    signals = ", ".join(f"{one.name} [{one.unit}]" for one in core.inputs)
    lines = (
        f"{core.description}: {len(core.parameters)} parameters, {core.states} states, {len(core.outputs)} outputs",
        f"signals: {signals}",
        f"module: {len(module.binary):,} bytes, {module.packed:,} by gzip",
    )
    return Summary("", [Sentence(line) for line in lines], data)
