"""Suite of exporters: their common options, and the exit code for a missing scenario."""

from typer.core import TyperCommand

from martensite.testing.commands import list_options
from martensite.testing.conformance import require_condition

COMMON = ("--set", "--import", "--out", "--force")


def check_options(command: TyperCommand) -> None:
    """It has the options for changes, imports, output folder and overwriting."""
    missing = [name for name in COMMON if name not in list_options(command)]
    require_condition(not missing, f"it has no option `{', '.join(missing)}`")


def check_missing_scenario(command: TyperCommand) -> None:
    """It refuses a missing scenario with exit code 2."""
    try:
        command.main(["no-such-scenario.toml"], standalone_mode=False)
    except Exception as error:  # of Martensite or of Typer; both have an exit code
        code = getattr(error, "exit_code", 1)
    else:
        code = 0
    require_condition(code == 2, f"the exit code is {code}")
