"""Sphinx extension: every page with code cells is executed in a process of its own.

The processes are copies of one that has imported the modules of the setting `pages_begin_with`,
so that a page does not wait for its imports; the `martensite …` commands of a page are made in
the same way. A cell or a command that fails fails the build. This takes the place of the
executor of MyST-NB, which starts a Jupyter kernel for every page.
"""

from __future__ import annotations

import time
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import myst_nb.core.execute
import processes
from myst_nb.core.execute.base import ExecutionError, NotebookClientBase
from nbformat import from_dict

WARM = get_context("forkserver")
"""Makes processes as copies of one that has imported what `pages_begin_with` names."""


class Client(NotebookClientBase):
    """Executes a page before it is rendered."""

    def start_client(self) -> None:
        """Execute the page; its cells hold their outputs afterwards.

        Raises:
            ExecutionError: A cell fails, or the page takes longer than it may.
        """
        start = time.perf_counter()
        with TemporaryDirectory() as folder:
            self._execute(folder)
        taken = time.perf_counter() - start
        self.logger.info(f"Executed in {taken:.1f} s")
        self.exec_metadata = {
            "mtime": time.time(),
            "runtime": taken,
            "method": "forked",
            "succeeded": True,
            "error": None,
            "traceback": None,
        }

    def _execute(self, folder: str) -> None:
        self.notebook.metadata["language_info"] = {"name": "python", "pygments_lexer": "ipython3"}
        coded = [cell for cell in self.notebook.cells if cell.cell_type == "code"]
        ways, theirs = WARM.Pipe()
        sources = [cell.source for cell in coded]
        process = WARM.Process(target=processes.run_cells, args=(theirs, folder, sources))
        process.start()
        theirs.close()
        try:
            for count, cell in enumerate(coded, 1):
                outputs, failure = self._outputs(ways, cell.source)
                cell.outputs, cell.execution_count = [from_dict(o) for o in outputs], count
                if failure:
                    raise ExecutionError(f"{self.path}, cell {count}:\n{cell.source}\n\n{failure}")
        finally:
            process.kill()
            process.join()

    def _outputs(self, ways: Connection, source: str) -> Any:
        """Outputs of the next cell; meanwhile, its commands are run."""
        limit = time.monotonic() + self.nb_config.execution_timeout
        while ways.poll(max(0.0, limit - time.monotonic())):
            try:
                kind, content = ways.recv()
            except EOFError:
                raise ExecutionError(f"{self.path}: the process ended in\n{source}") from None
            if kind == "cell":
                return content
            line, folder, variables = content
            ways.send(_done(line, folder, variables, limit))
        raise ExecutionError(f"{self.path}: this cell takes too long\n{source}")


def _done(line: str, folder: str, variables: dict[str, str], limit: float) -> tuple[int | None, str, str]:
    """Exit status, standard output and standard error of a command."""
    with TemporaryDirectory() as kept:
        arguments = (line, folder, variables, kept)
        process = WARM.Process(target=processes.run_command, args=arguments)
        process.start()
        process.join(max(0.0, limit - time.monotonic()))
        process.kill()
        process.join()
        out, err = (path.read_text("utf-8") for path in sorted(Path(kept).iterdir()))
        return process.exitcode, out, err


def _prepare(app: Any, config: Any) -> None:
    WARM.set_forkserver_preload(list(config.pages_begin_with))


def setup(app: Any) -> dict[str, Any]:
    """Entry point of the extension."""
    app.add_config_value("pages_begin_with", [], "")
    app.connect("config-inited", _prepare)
    myst_nb.core.execute.NotebookClientDirect = Client  # type: ignore[misc]
    return {"parallel_read_safe": False, "parallel_write_safe": True}
