"""`fit`: estimate parameters from measurements."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.cli.app import app
from martensite.cli.folder_group import FolderGroup, make_group

if TYPE_CHECKING:
    from typer._click import Context

LOGS = "logs"
"""Default command."""


class Fits(FolderGroup):
    """Commands of `fit`; the default is `logs`."""

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Insert the default command if needed."""
        return super().parse_args(ctx, self.prepend_command(args))

    def prepend_command(self, args: list[str]) -> list[str]:
        """Return the arguments with the command first."""
        if not args or args[0] in ("-h", "--help") or self._names(args[0]):
            return args
        return [LOGS, *args]

    def _names(self, word: str) -> bool:
        if self.load_command(word):
            return True
        near = get_close_matches(word, self.commands, n=1, cutoff=0.7)
        return bool(near) and not Path(word).exists()


fit = make_group(
    __name__,
    Fits,
    short_help="Fit parameters of a material, wire or motor to logs.",
    help=(
        "Fit parameters to logs: `martensite fit LOG... --scenario S --free A_s,A_f`, `martensite fit "
        "FILE.toml`, or one of the commands below."
    ),
)
app.add_typer(fit, name="fit", rich_help_panel="From logs")
