"""A Cortex-M4 under QEMU (`netduinoplus2`, an STM32F405), whose time is the count of its instructions."""

from __future__ import annotations

import socket
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from martensite.base.errors import SolveError
from martensite.boards.emulators.toolchains import require_tool

MACHINE = "netduinoplus2"
CLOCK = ("-icount", "shift=3")
"""An instruction takes 8 ns, so a slow host cannot let the watchdog of the board run out."""
START_LIMIT = 10.0
"""Time limit for the start of QEMU [s]."""


@dataclass
class QemuBoard:
    """A board under QEMU as a port: its USART1 on a socket."""

    elf: Path
    words: tuple[str, ...] = ()
    _folder: Any = field(default_factory=tempfile.TemporaryDirectory)

    def __post_init__(self) -> None:
        place = Path(self._folder.name) / "line"
        command = [require_tool("qemu-system-arm"), "-M", MACHINE, *CLOCK, "-nographic", "-monitor", "none"]
        command += ["-serial", f"unix:{place},server=on,wait=off", "-kernel", str(self.elf), *CLOCK, *self.words]
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self._line, until = socket.socket(socket.AF_UNIX), time.monotonic() + START_LIMIT
        while True:
            try:
                self._line.connect(str(place))
                break
            except OSError:
                if time.monotonic() > until or self._process.poll() is not None:
                    self.close()
                    raise SolveError("QEMU does not begin.") from None
                time.sleep(0.02)
        self._line.settimeout(0.002)

    def write(self, data: bytes) -> int:
        """Send bytes to the board."""
        self._line.sendall(data)
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Return the output of the board."""
        try:
            return self._line.recv(size)
        except TimeoutError:
            return b""

    def close(self) -> None:
        """End the emulator."""
        self._line.close()
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()
