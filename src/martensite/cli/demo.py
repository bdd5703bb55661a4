"""`demo`: a published actuator test rebuilt, from scenario to figure and verdicts."""

from __future__ import annotations

from pathlib import Path

from martensite.cli.app import app
from martensite.cli.options import Json

NAME = "migaone"


@app.command()
def demo(json: Json = False) -> None:
    """Rebuild a published test; writes migaone.nc and migaone.png."""
    from martensite.cli import show
    from martensite.cli.execute import Wanted, execute
    from martensite.cli.outputs import Outputs
    from martensite.cli.study import print_claims
    from martensite.scenario.scenario import load
    from martensite.studies.base import load_study
    from martensite.studies.migaone.bench import SCENARIO

    outputs = Outputs(Path(f"{NAME}.nc"), Path(f"{NAME}.png")).check(force=True)
    done = execute(load(SCENARIO), Wanted(outputs))
    study = load_study(NAME)
    claims = study.claims()
    if json:
        show.as_json({"run": done.summary(), "claims": [claim.to_dict() for claim in claims]})
        return
    done.show(json=False)
    show.text()
    print_claims(study, claims, brief=True)
    show.text(f"All {len(claims)} claims with their reasons: martensite study {NAME}")
