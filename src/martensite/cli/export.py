"""`export`: a scenario in the form of another program: C99, an FMU, WebAssembly, or MJCF."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Option

from martensite.base.errors import InputError, ParameterError, suggest_name
from martensite.base.formats import write_quantity
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.export_ports import Port, opensees, umat, write_core_alone
from martensite.cli.options import (
    Force,
    Json,
    ScenarioSource,
    Text,
    Texts,
    read_positive,
    read_quantity,
    spread_options,
)
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.export.c_core import CCore
    from martensite.export.fmu import Fmu
    from martensite.export.wasm import WasmModule
    from martensite.scenario.scenario import Scenario

export = typer.Typer(help="Write a scenario for another program.", no_args_is_help=True)
app.add_typer(export, name="export")
PARTS = ("whole", "plant", "loop")
ALONE = ("element", "material")
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
            "supervisor without the plant, for a controller board; element, material: alone, for a host, with slopes."
        ),
    ] = "whole",
    port: Port = None,
    precision: Annotated[str, Option(help="float64 (double), or float32 (float).")] = "float64",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as C99: header, source, and an example that plays its drive.

    No allocation, no library but libm; in double the results are those of `run`, bit for bit.
    Operations are counted at worst: what is not chosen in a step is not computed.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import choose_identifier
    from martensite.show.terminal import print_summary

    if part not in (known := (*PARTS, *ALONE)):
        raise ParameterError(f"There is no part `{part}`. {suggest_name(part, known)}")
    if port is not None and part not in ALONE:
        raise InputError(f"Option `--port` goes with `--part element` or `--part material`, not with `{part}`.")
    name = choose_identifier(name, source.file.stem)
    ends = (".h", ".c") if part in ALONE else (".h", ".c", "_example.c")
    files = _check_files(out, [f"{name}{end}" for end in ends], force)
    core, example, tried = _make_core(source.load(), name, part, precision, port)
    make_folder(out)
    with replace_together():
        core.write(out)
        if example:
            write_file(files[-1], example)
    print_summary(_summarise_core(core, part, tried), json, files)


def _check_files(folder: Path, names: Sequence[str], force: bool) -> list[Path]:
    """The files that will be written; `DataError` if one is there already.

    The folder is made if it is missing, but not what it is in.
    """
    files = [folder / name for name in names]
    missing = not folder.exists()
    for path in [folder.parent / names[1]] if missing else files:
        Outputs(path, None).check(force or missing, data=(path.suffix,))
    return files


def _make_core(loaded: Scenario, name: str, part: str, precision: str, port: str | None) -> tuple[CCore, str, str]:
    """The core of a part of a scenario, the text of its example if it has one, and how far it was tried."""
    if part in ALONE:
        return write_core_alone(loaded.system, part, port, name, precision), "", ""
    from martensite.export.c_core import build_c_core, build_c_loop
    from martensite.export.c_example import (
        MOST,
        MOST_TRIED,
        example_text,
        played_by_loop,
        played_by_system,
        try_program,
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
    blocks = [
        Sentence(f"{core.description}, {core.precision}"),
        Sentence(f"model: {core.size:,} bytes ({numbers})"),
        DataTable(("operations at most", "sum", *kinds), rows, right=range(1, len(kinds) + 2)),
        *([Sentence(tried)] if tried else []),
    ]
    return Summary("", blocks, data)


@export.command("fmu")
@spread_options
def fmu(
    source: ScenarioSource,
    fmi: Annotated[str, Option(help="Version of FMI: 2.0 or 3.0.")] = "2.0",
    out: Annotated[Path | None, Option(help="FMU to write [default: ./SCENARIO.fmu].")] = None,
    step: Annotated[
        Text,
        Option(
            help="Longest step of the model within a step of the co-simulation "
            "[default: that with which `run` reaches its tolerance]."
        ),
    ] = None,
    name: Annotated[Text, Option(help="Model identifier [default: made of the name of the file].")] = None,
    platforms: Annotated[
        Texts,
        Option(
            "--platform",
            help="For which to compile, e.g. x86_64-windows, with gcc or zig; repeatable "
            "[default: all that gcc is there for].",
        ),
    ] = None,
    ports: Annotated[
        bool,
        Option(
            "--ports", help="The element alone: its elongation, drive and surroundings in; force and temperature out."
        ),
    ] = False,
    port: Port = None,
    model_exchange: Annotated[
        bool,
        Option(
            "--model-exchange",
            help="Refuse unless it is for model exchange too, as it is by itself where laws have rates.",
        ),
    ] = False,
    sources_only: Annotated[bool, Option("--sources-only", help="Compile nothing.")] = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as an FMU for co-simulation: the model in C, compiled and as sources.

    Drives are inputs, everything that can be observed is an output, all numbers of the scenario
    are parameters; a closed loop has its reference as an input. With `--ports` it is the element
    alone, for a host that has the mechanism. One element on a static load line, or alone, whose law
    has rates (`mas`, `mas-polycrystal`) is for model exchange too.
    """
    from martensite.export.fmu import to_fmu
    from martensite.show.terminal import print_summary

    if port is not None and not ports:
        raise InputError("Option `--port` chooses the element of an FMU with `--ports`.")
    if sources_only and platforms:
        raise InputError("Options `--sources-only` and `--platform` exclude each other.")
    loaded = source.load()
    out = out or Path(f"{source.file.stem}.fmu")
    Outputs(out, None).check(force, data=(".fmu",))
    chosen = read_quantity("step", step, "s")
    compiled = [] if sources_only else platforms or None
    made = to_fmu(
        loaded,
        out,
        fmi=fmi,
        step=chosen,
        name=name,
        platforms=compiled,
        ports=ports,
        port=port,
        model_exchange=model_exchange,
    )
    print_summary(_summarise_fmu(made), json)


def _collect_signals(made: Fmu) -> dict[str, Any]:
    report = {
        "file": str(made.path),
        "fmi": made.fmi,
        "identifier": made.name,
        "token": made.token,
        "period" if made.discrete else "step": made.step,
        "platforms": list(made.platforms),
    }
    kinds = {"inputs": "input", "outputs": "output", "parameters": "parameter"}
    named = {key: made.named(causality) for key, causality in kinds.items()}
    named["fixed"] = [one for one in made.named("local") if one.variability == "constant"]
    named["states"] = made.states
    return report | {key: {one.name: one.reference for one in signals} for key, signals in named.items()}


def _summarise_fmu(made: Fmu) -> Summary:
    counts = {kind: len(made.named(kind)) for kind in ("input", "output", "parameter")}
    counted = [f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()]
    inputs = ", ".join(f"{one.name} [{one.unit or '-'}]" for one in made.named("input"))
    pace = "period" if made.discrete else "inner step of at most"
    known = ", ".join(made.platforms) or "no platform: compile its sources before use"
    lines = (
        f"{', '.join(counted)}; {pace} {write_quantity(made.step, 's')}",
        f"inputs: {inputs}",
        *[f"for model exchange too, with {len(made.states)} continuous states"] * bool(made.states),
        f"wrote {made.path} (FMI {made.fmi}; {known})",
    )
    return Summary("", [Sentence(line) for line in lines], _collect_signals(made))


@export.command("wasm")
@spread_options
def wasm(
    source: ScenarioSource,
    out: Annotated[Path | None, Option(metavar="FOLDER", help="Where to write [default: ./SCENARIO_wasm].")] = None,
    name: Annotated[Text, Option(help="Name of the files [default: SCENARIO].")] = None,
    part: Annotated[str, Option(help="whole; plant: without the loops around it.")] = "whole",
    slopes: Annotated[
        Text, Option(metavar="NAMES", help="Parameters and signals by which outputs have derivatives, comma-separated.")
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as WebAssembly for browsers and Node.js: module, script with types, guide.

    It imports nothing, and gives the numbers of `export c`. Zig compiles it: `pip install
    "martensite[cc]"`, unless there is one.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import choose_identifier
    from martensite.export.wasm.module import find_wasm_compiler
    from martensite.show.terminal import print_summary

    if part not in PARTS[:2]:
        raise ParameterError(f"There is no part `{part}`. {suggest_name(part, PARTS[:2])}")
    name = choose_identifier(name, source.file.stem)
    out = out or Path(f"{source.file.stem}_wasm")
    names = (f"{name}.wasm", f"{name}.js", f"{name}.d.ts", "README.md")
    files = _check_files(out, names, force)
    find_wasm_compiler()
    made = _make_module(source.load(), name, part, [one.strip() for one in (slopes or "").split(",") if one.strip()])
    make_folder(out)
    with replace_together():
        for path in files:
            write_file(path, made.files[path.name])
    print_summary(_summarise_module(made), json, files)


def _make_module(loaded: Scenario, name: str, part: str, slopes: Sequence[str]) -> WasmModule:
    from martensite.export.c_example import played_by_system
    from martensite.export.wasm import build_wasm

    system = loaded.system if part == "plant" else loaded.whole
    first, _ = played_by_system(system, loaded.waveform, loaded.duration, STEPS)
    return build_wasm(system, name=name, title=loaded.title or name, first=first, slopes=slopes)


def _summarise_module(made: WasmModule) -> Summary:
    core = made.core
    data = {
        "name": core.name,
        "described": core.description,
        "module_bytes": len(made.binary),
        "packed_bytes": made.packed,
        "parameters": len(core.parameters),
        "states": core.states,
        "sample_time": core.sample_time,
        "signals": {one.name: one.unit for one in core.inputs},
        "outputs": {one.name: one.unit for one in core.outputs},
        "slopes": list(made.slopes.names) if made.slopes else [],
    }
    signals = ", ".join(f"{one.name} [{one.unit}]" for one in core.inputs)
    slopes = f"slopes by {', '.join(made.slopes.names)}" if made.slopes else "no slopes (`--slopes`)"
    lines = (
        f"{core.description}: {len(core.parameters)} parameters, {core.states} states, {len(core.outputs)} outputs",
        f"signals: {signals}",
        f"module: {len(made.binary):,} bytes, {made.packed:,} by gzip; {slopes}",
    )
    return Summary("", [Sentence(line) for line in lines], data)


@export.command("mujoco")
@spread_options
def mujoco(
    source: ScenarioSource,
    out: Annotated[
        Path | None, Option(help="MJCF file to write [default: ./SCENARIO.xml, or ./SCENARIO_snippet.xml].")
    ] = None,
    snippet: Annotated[bool, Option("--snippet", help="Sites and tendons alone, for a model of your own.")] = False,
    timestep: Annotated[str, Option(help="Time step of the model.")] = "2 ms",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write the mechanism of a scenario as an MJCF model, or the lines that another model needs.

    The model has a tendon at the place of every element. In Python, `ms.export.to_mujoco` adds the elements
    themselves, and `ms.export.MujocoActuators` adds them to any model.
    """
    from martensite.base.files import write_file
    from martensite.export.mjcf import to_mjcf
    from martensite.export.mjcf_snippet import to_mjcf_snippet
    from martensite.show.terminal import print_summary

    loaded = source.load()
    out = out or Path(f"{source.file.stem}{'_snippet' if snippet else ''}.xml")
    Outputs(out, None).check(force, data=(".xml",))
    dt = read_positive("timestep", timestep, "s")
    write_file(out, to_mjcf_snippet(loaded.system) if snippet else to_mjcf(loaded.system, timestep=dt))
    print_summary(_summarise_model(loaded), json, [out])


def _summarise_model(loaded: Scenario) -> Summary:
    from martensite.export.mjcf import start_forces

    mechanism, tendons = loaded.system.mechanism, start_forces(loaded.system)
    left_out = list(mechanism.signals())
    data = {"mechanism": mechanism.registered_name, "tendons": tendons, "left_out": left_out}
    lines = [
        *(f"tendon `{one}`: {write_quantity(f, 'N')} at assembly" for one, f in tendons.items()),
        *(f"signal `{one}` of the mechanism is left out: it is for the model to say" for one in left_out),
    ]
    return Summary("", [Sentence(line) for line in lines], data)


export.command("umat")(umat)
export.command("opensees")(opensees)
