"""The host's end of a link: commands that are answered, telemetry that is counted.

Commands are sent again, as new frames, until they are answered: all of them may be said twice without harm. What comes
meanwhile is kept and given out by `receive`.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

from martensite.base.errors import InputError, SolveError, suggest_name
from martensite.boards.link.frames import BoardClock, FrameReader, encode_frame
from martensite.boards.link.messages import ARM_WORD, VERSION, BoardAnswer, Message, Mode, pack_message

LONGEST_WRITE = 0.5
"""Time [s] after which a line that accepts no more bytes is given up."""
TRIES, WAIT = 5, 0.2
"""Number of attempts of a command, and time limit of each answer [s]."""
ARM = "ARM"
"""The word of a person without which nothing is armed."""


class Port(Protocol):
    """A line to a board, such as a `serial.Serial`."""

    def read(self, size: int = 1) -> bytes:
        """Up to so many bytes, after its own timeout at the latest."""
        ...

    def write(self, data: bytes, /) -> Any:
        """Send bytes."""
        ...

    def close(self) -> None:
        """Let the line go."""
        ...


def open_port(address: str, baud: int = 500_000) -> Port:
    """Return a serial line: a device such as `/dev/ttyACM0` or `COM3`, or an address of pyserial such as `socket://`.

    Raises:
        InputError: it cannot be opened; the sentence names the ports that there are.
    """
    import serial
    from serial.tools.list_ports import comports

    try:
        return serial.serial_for_url(address, baudrate=baud, timeout=0.002, write_timeout=LONGEST_WRITE)
    except (serial.SerialException, ValueError, OSError) as error:
        known = [one.device for one in comports()]
        there = f"There are {', '.join(known)}." if known else "No serial port is there."
        raise InputError(f"The port `{address}` cannot be opened: {error}. {there}") from None


@dataclass
class BoardLink:
    """One board, asked and listened to."""

    port: Port
    reader: FrameReader = field(default_factory=FrameReader)
    clock: BoardClock = field(default_factory=BoardClock)
    now: Callable[[], float] = time.monotonic
    """Time of the host [s]; a test may give another clock."""
    _sent: int = 0
    _waiting: deque[Message] = field(default_factory=lambda: deque[Message]())

    def send(self, name: str, **values: Any) -> int:
        """Send a message without waiting for its answer, and return its number.

        Raises:
            SolveError: the line is lost, or accepts no more bytes.
        """
        code, payload = pack_message(name, **values)
        number, self._sent = self._sent, (self._sent + 1) % 65536
        try:
            self.port.write(encode_frame(code, number, payload))
        except OSError as error:
            import serial

            if isinstance(error, serial.SerialTimeoutException) and isinstance(self.port, serial.Serial):
                self.port.reset_output_buffer()  # closing the port would wait for bytes that the board does not read
            raise _describe_loss(error) from None
        return number

    def receive(self) -> Iterator[Message]:
        """Yield the messages since the last call, oldest first; those that are not taken stay for the next call."""
        self._waiting.extend(self._read())
        while self._waiting:
            yield self._waiting.popleft()

    def greet(self, digest: int | None = None) -> Message:
        """Return the `hello` of the board; if a digest is given, check the firmware.

        Raises:
            SolveError: the board does not answer.
            InputError: the board speaks another version, or holds another firmware.
        """
        self.reader.restart()
        found = self._ask(
            "ping", lambda m, _: m.name == "hello" and m.values["token"] == self._token, token=self._token
        )
        version = found.values["version"]
        if version != VERSION:
            raise InputError(
                f"The board speaks version {version} of the link, this program {VERSION}: write the firmware again."
            )
        if digest not in (None, found.values["digest"]):
            raise InputError("The board holds another firmware than this project: write it to the board again.")
        return found

    @property
    def _token(self) -> int:
        return id(self) % (1 << 32)

    def command(self, name: str, **values: Any) -> None:
        """A command that the board must take.

        Raises:
            SolveError: it refuses, or does not answer.
        """
        found = self._ask(name, lambda m, number: m.name == "answer" and m.values["to"] == number, **values)
        result = BoardAnswer(found.values["result"])
        if result is not BoardAnswer.DONE:
            raise SolveError(f"The board answers `{name}` with: {ANSWERS[result]}.")

    def arm(self, word: str) -> None:
        """Let signals pass; `word` must be `ARM`, said by a person.

        Raises:
            InputError: another word.
        """
        if word != ARM:
            raise InputError(f"Nothing is armed without the word `{ARM}`, but `{word}` was given.")
        self.command("arm", word=ARM_WORD)

    def disarm(self) -> None:
        """All signals off."""
        self.command("disarm")

    def choose_mode(self, name: str) -> None:
        """Set the source of the signals: `idle`, `loop`, `waveform` or `emulated`.

        Raises:
            InputError: the mode is unknown.
        """
        known = {mode.name.lower(): mode for mode in Mode}
        if name not in known:
            raise InputError(f"There is no mode `{name}`. {suggest_name(name, known)}")
        self.command("mode", mode=int(known[name]))

    def _read(self) -> list[Message]:
        try:
            return list(self.reader.feed(self.port.read(4096)))
        except OSError as error:
            raise _describe_loss(error) from None

    def _ask(self, name: str, fits: Callable[[Message, int], bool], **values: Any) -> Message:
        for _ in range(TRIES):
            number, until = self.send(name, **values), self.now() + WAIT
            while self.now() < until:
                came = self._read()  # also what comes behind an answer
                found = next((one for one in came if fits(one, number)), None)
                self._waiting.extend(one for one in came if one is not found)
                if found is not None:
                    return found
        raise SolveError(
            f"The board does not answer `{name}` ({TRIES} tries in {TRIES * WAIT:g} s): check the cable, the baud "
            "rate, and that the firmware runs."
        )


def _describe_loss(error: OSError) -> SolveError:
    return SolveError(
        f"The line to the board failed ({error}): check the cable, that the board runs, and that no other program uses "
        "the port."
    )


ANSWERS = {
    BoardAnswer.UNKNOWN: "it does not know this command",
    BoardAnswer.REFUSED: "not now, it is not armed or in another mode",
    BoardAnswer.OUT_OF_RANGE: "the number is out of its range",
    BoardAnswer.FULL: "there is no room for another level",
}
