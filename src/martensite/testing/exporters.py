"""Suite of exporters: their common options, and the exit code for a missing scenario."""

from typer.core import TyperCommand

from martensite.testing.commands import list_options
from martensite.testing.conformance import require_condition

COMMON = ("--set", "--import", "--out", "--force")
"""Options of all exporters."""


def check_options(command: TyperCommand) -> None:
    """It takes changes of the scenario, a place to write to, and leave to replace files."""
    missing = [name for name in COMMON if name not in list_options(command)]
    require_condition(not missing, f"it has no option `{', '.join(missing)}`")


def check_missing_scenario(command: TyperCommand) -> None:
    """It refuses a scenario that does not exist, with exit code 2."""
    try:
        command.main(["no-such-scenario.toml"], standalone_mode=False)
    except Exception as error:  # of Martensite or of Typer; both have an exit code
        code = getattr(error, "exit_code", 1)
    else:
        code = 0
    require_condition(code == 2, f"the exit code is {code}")
