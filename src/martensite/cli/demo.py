"""`demo`: a published actuator test rebuilt, from scenario to figure and verdicts."""

from __future__ import annotations

from pathlib import Path

import typer

from martensite.cli.app import app
from martensite.cli.options import Json

NAME = "migaone"


@app.command()
def demo(json: Json = False) -> None:
    """Rebuild a published test; writes migaone.nc and migaone.png."""
    from martensite.cli.outputs import Outputs
    from martensite.cli.run import RunOptions, run_scenario
    from martensite.cli.study import summarise_claims
    from martensite.scenario.scenario import load
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import load_study
    from martensite.studies.migaone.bench import SCENARIO

    outputs = Outputs(Path(f"{NAME}.nc"), Path(f"{NAME}.png")).check(force=True)
    _, done = run_scenario(load(SCENARIO), RunOptions(), outputs)
    study = load_study(NAME)
    claims = summarise_claims(study, study.claims(), brief=True)
    if json:
        files = [str(path) for path in outputs.paths()]
        run = done.data | {"files": files}
        print_json({"run": run, "claims": claims.data["claims"]})
        return
    print_summary(done, files=outputs.paths())
    typer.echo()
    print_summary(claims)
    count = len(claims.data["claims"])
    typer.echo(f"All {count} claims with their reasons: martensite study {NAME}")
