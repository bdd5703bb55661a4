"""`demo`: a published actuator test rebuilt, from scenario to figure and verdicts."""

from __future__ import annotations

from pathlib import Path

import typer

from martensite.cli.app import app
from martensite.cli.options import Json

NAME = "migaone"


@app.command()
def demo(json: Json = False) -> None:
    """Rebuild a published test; writes migaone.nc and migaone.png.

    Where its study is installed, the claims of the source follow.
    """
    from martensite.cli.outputs import Outputs
    from martensite.cli.run import RunOptions, run_scenario
    from martensite.cli.study import summarise_claims
    from martensite.scenario.examples import EXAMPLES
    from martensite.scenario.scenario import load
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import INSTALLATION, STUDIES

    outputs = Outputs(Path(f"{NAME}.nc"), Path(f"{NAME}.png")).check(force=True)
    _, done = run_scenario(load(EXAMPLES / f"{NAME}.toml"), RunOptions(), outputs)
    claims = None
    if NAME in STUDIES.names():
        study = STUDIES[NAME]()
        claims = summarise_claims(study, study.claims(), brief=True)
    if json:
        files = [str(path) for path in outputs.paths()]
        run = done.data | {"files": files}
        print_json({"run": run, "claims": claims.data["claims"] if claims else None})
        return
    print_summary(done, files=outputs.paths())
    typer.echo()
    if claims is None:
        typer.echo(f"The claims of its source are a study; {INSTALLATION}.")
        return
    print_summary(claims)
    count = len(claims.data["claims"])
    typer.echo(f"All {count} claims with their reasons: martensite study {NAME}")
