"""A Python program that moves a MuJoCo model with the elements of a scenario.

It is written from the template below, with the text of the scenario, the names of the tendons and the forces at the
start in it. Its loop is that of `MujocoBridge.run`, step for step, laid open so that controllers can act in it.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from string import Template

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.export.mjcf import start_forces


def driver_text(
    system: AbstractSystem,
    scenario: str,
    path: Path,
    *,
    source: Path,
    model: Path | None = None,
    modules: tuple[str, ...] = (),
) -> str:
    """The program for a system, as Python.

    Args:
        system: what the scenario describes.
        scenario: its text; the drive in it is what is played.
        path: where the program will be; it finds other files from there.
        source: the scenario file: what it names is found beside it.
        model: the MJCF file that is moved, as `to_mjcf` writes it; None for one that is named
            whenever the program is called.
        modules: that register parts of one's own: dotted names, or .py files.

    Raises:
        InputError: there is no element in the system.
    """
    forces = start_forces(system)
    if not forces:
        raise InputError(f"There is no shape-memory element in {system.description()}.")
    rows = [f"    {_write_text(port)}: ({_write_text(port)}, {force!r})," for port, force in forces.items()]
    own = [_load_module(path, name) for name in modules]
    return Template(_DRIVER).substitute(
        NAME=re.sub(r'[\\"]', "_", path.name),
        USAGE="[MODEL.xml]" if model else "MODEL.xml",
        MODEL=f"HERE / {_write_text(_make_relative(path, model))}" if model else "None",
        ELEMENTS="\n".join(rows),
        COUPLING=_write_text("centred" if model else "end"),
        SOURCE=_write_text(_make_relative(path, source)),
        IMPORTED="from martensite.cli.options import import_modules\n" if modules else "",
        IMPORT=f"    import_modules([{', '.join(own)}])\n" if modules else "",
        SCENARIO=_quote_text(scenario),
    )


def _make_relative(path: Path, other: Path) -> str:
    try:
        return Path(os.path.relpath(other.absolute(), path.absolute().parent)).as_posix()
    except ValueError:  # on another drive
        return other.absolute().as_posix()


def _load_module(path: Path, name: str) -> str:
    return f"str(HERE / {_write_text(_make_relative(path, Path(name)))})" if name.endswith(".py") else _write_text(name)


def _write_text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)


def _quote_text(text: str) -> str:
    inner = text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    return f'"""\\\n{inner.rstrip()}\n"""'


_DRIVER = '''\
"""Moves a MuJoCo model with shape-memory elements, by the drive of a scenario; writes a CSV in SI.

    python $NAME $USAGE [--csv FILE] [--film FILE.mp4] [--view]

Written by martensite, and yours to change: controllers of your own go into `run`.
"""

import argparse
import csv
import math
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import martensite as ms
import mujoco
${IMPORTED}from martensite.export.mujoco_plant import scalar_joints
from martensite.base.files import replace_file
from martensite.scenario.overrides import read_settings
from martensite.scenario.scenario import read_scenario

HERE = Path(__file__).resolve().parent
MODEL = $MODEL
COUPLING = $COUPLING  # "centred" is of second order, "end" is stable at any step
# element of the scenario: (tendon of the model, force where the model starts [N])
ELEMENTS = {
$ELEMENTS
}


def along(tendon, force, one):
    """An element of the scenario at a tendon."""
    parts = {"element": one.element, "environment": one.environment, "source": one.source}
    return ms.export.TendonActuator(tendon=tendon, start_force=force, **parts)


def drives(scenario, dt):
    """Of each tendon: its waveform, and when in a step of dt [s] that is asked."""
    waves = ms.export.tendon_signals(scenario.system, scenario.waveform)
    for port, one in scenario.system.actuators().items():
        if len(waves[port].edges(scenario.duration)) * dt > scenario.duration:
            raise ms.InputError(f"The drive of `{port}` switches more than once in {dt:g} s.")
        yield ELEMENTS[port][0], waves[port], dt if one.source.sets_temperature else 0.5 * dt


def run(scenario, bridge, viewer=None):
    """Play the drive; the columns of the run."""
    model, data, dt = bridge.model, bridge.data, bridge.model.opt.timestep
    played, joints = list(drives(scenario, dt)), scalar_joints(model, None)
    result = ms.export.MujocoResult(dt)
    steps = max(1, math.ceil(scenario.duration / dt - 1e-9))
    every, begun = math.ceil(steps / (scenario.samples - 1)), time.monotonic()
    for k in range(steps + 1):
        rows = bridge.observe({tendon: wave.value(data.time) for tendon, wave, _ in played})
        result.follow(data.time, rows)  # alarms are judged at every step
        if k % every == 0 or k == steps:
            result.sample(data, rows, joints)
        if k == steps or (viewer and not viewer.is_running()):
            break
        mujoco.mj_step1(model, data)  # positions, velocities and sensors are those of now
        # Controllers of your own act here: on `signals`, or on data.ctrl of other actuators.
        signals = {tendon: wave.value(data.time + later) for tendon, wave, later in played}
        bridge.step(signals)  # the tensions of the step go to data.ctrl, then mj_step
        if viewer:
            viewer.sync()
            time.sleep(max(0.0, begun + k * dt - time.monotonic()))
    for strand in bridge.strands:
        result.judge(strand)
    return result


def write(result, path):
    """Write time, joints, and what is known of every element."""
    names = ["time", *result.joints]
    names += [f"{tendon}.{name}" for tendon, own in result.tendons.items() for name in own]
    with replace_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(names)
        rows.writerows(zip(*(result[name] for name in names)))


def window(bridge):
    """MuJoCo's own, on the model; it needs a screen."""
    from mujoco.viewer import launch_passive

    return launch_passive(bridge.model, bridge.data)


def main():
    """Read the command line, run, and write what is wanted."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\\n")[0])
    parser.add_argument("model", nargs="?" if MODEL else None, default=MODEL, help="MJCF file")
    parser.add_argument("--set", action="append", metavar="PATH=VALUE", help="of the scenario")
    parser.add_argument("--keyframe", help="where the model starts")
    parser.add_argument("--hold", action="store_true", help="start with what holds it still")
    parser.add_argument("--csv", type=Path, default=Path(f"{Path(__file__).stem}.csv"))
    parser.add_argument("--film", type=Path, help=".mp4, .gif, or .png for the last pose")
    parser.add_argument("--view", action="store_true", help="look on, as fast as in life")
    given = parser.parse_args()
${IMPORT}    scenario = read_scenario(SCENARIO, SOURCE, read_settings(given.set or []))
    forces, system = dict(ELEMENTS.values()), scenario.system
    if given.hold:
        forces = ms.export.holding_tensions(given.model, list(forces), keyframe=given.keyframe)
    wires = [along(t, forces[t], system.actuators()[port]) for port, (t, _) in ELEMENTS.items()]
    bridge = ms.export.MujocoBridge(given.model, wires, keyframe=given.keyframe, coupling=COUPLING)
    with window(bridge) if given.view else nullcontext() as viewer:
        result = run(scenario, bridge, viewer)
    write(result, given.csv)
    print(*result.warnings, f"wrote {given.csv}", sep="\\n")
    if given.film:
        camera = bridge.model.camera(0).name if bridge.model.ncam else None
        print("wrote", ms.export.render_mujoco(bridge.model, result, given.film, camera=camera))


SOURCE = HERE / $SOURCE  # files that the scenario names are found beside it
SCENARIO = $SCENARIO

if __name__ == "__main__":
    try:
        main()
    except ms.MartensiteError as error:
        sys.exit(f"error: {error}")
'''
