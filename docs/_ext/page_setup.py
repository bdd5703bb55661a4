"""What the hidden first cell of an executed page imports: figures are drawings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from IPython import get_ipython
from matplotlib_inline.config import InlineBackend

from martensite.show.figures.style import STYLE

CHECKOUT = Path(__file__).parents[2]
EXAMPLES = CHECKOUT / "examples"
"""The example scenarios of the repository; a page runs in a folder of its own."""


def link_checkout() -> None:
    """Link the folders of the repository that commands name by their path in it."""
    for name in ("examples", "src"):
        Path(name).symlink_to(CHECKOUT / name)


shell: Any = get_ipython()  # type: ignore[no-untyped-call]
shell.run_line_magic("matplotlib", "inline")
inline: Any = InlineBackend.instance(parent=shell)
inline.figure_formats = {"svg"}
# figures are laid out; to crop them, each would be drawn twice
inline.print_figure_kwargs = {"bbox_inches": None}
plt.rcParams.update(STYLE)
