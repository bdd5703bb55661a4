"""Host end of a link: answered commands and counted telemetry.

Commands are repeated as new frames until they are answered; repeating any of them is safe. `receive` returns messages
that arrive meanwhile.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

from martensite.base.errors import InputError, SolveError, suggest_name
from martensite.boards.link.frames import BoardClock, FrameReader, encode_frame
from martensite.boards.link.messages import ARM_WORD, VERSION, BoardAnswer, Message, Mode, ResetCause, pack_message

LONGEST_WRITE = 0.5
"""Time limit of a blocked write [s]."""
TRIES, WAIT = 5, 0.2
"""Attempts of a command, and time limit of each answer [s]."""
STALE, STALE_PERIODS = 0.5, 3.0
"""Age [s] of the newest telemetry above which a board counts as lost, and additional periods of its loop."""
LONGEST_STORE = 3.0
"""Time limit for storing a calibration [s]."""
ARM = "ARM"
"""Word of a person that is required for arming."""


class Port(Protocol):
    """A line to a board, such as a `serial.Serial`."""

    def read(self, size: int = 1) -> bytes:
        """Return up to `size` bytes, at the latest after its timeout."""
        ...

    def write(self, data: bytes, /) -> Any:
        """Send bytes."""
        ...

    def close(self) -> None:
        """Close the line."""
        ...


def find_stale(period: float) -> float:
    """Return the age of the newest telemetry above which a board counts as lost [s]."""
    return STALE + STALE_PERIODS * period


def open_port(address: str, baud: int = 500_000) -> Port:
    """Return a serial line: a device such as `/dev/ttyACM0` or `COM3`, or an address of pyserial such as `socket://`.

    Raises:
        InputError: it cannot be opened; the message names the existing ports.
    """
    import serial
    from serial.tools.list_ports import comports

    try:
        return serial.serial_for_url(address, baudrate=baud, timeout=0.002, write_timeout=LONGEST_WRITE)
    except (serial.SerialException, ValueError, OSError) as error:
        ports = [one.device for one in comports()]
        there = f"There are {', '.join(ports)}." if ports else "No serial port is there."
        raise InputError(f"The port `{address}` cannot be opened: {error}. {there}") from None


@dataclass
class BoardLink:
    """Commands to a board, and its messages."""

    port: Port
    reader: FrameReader = field(default_factory=FrameReader)
    clock: BoardClock = field(default_factory=BoardClock)
    now: Callable[[], float] = time.monotonic
    """Time of the host [s]; replaceable by another clock."""
    reset: ResetCause = ResetCause.UNKNOWN
    """Cause of the newest reset of the board, from the last `greet`."""
    _sent: int = 0
    _waiting: deque[Message] = field(default_factory=lambda: deque[Message]())

    def send(self, name: str, **values: Any) -> int:
        """Send a message without waiting for an answer, and return its number.

        Raises:
            SolveError: the line failed, or is blocked.
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
        """Yield the messages since the last call, oldest first; messages that are not consumed stay."""
        self._waiting.extend(self._read())
        while self._waiting:
            yield self._waiting.popleft()

    def greet(self, digest: int | None = None) -> Message:
        """Return the `hello` of the board, and check its firmware if a digest is given.

        Raises:
            SolveError: the board does not answer.
            InputError: the board has another version of the link, or another firmware.
        """
        self.reader.restart()
        hello = self._ask(
            "ping", lambda m, _: m.name == "hello" and m.values["token"] == self._token, token=self._token
        )
        version = hello.values["version"]
        self.reset = ResetCause(hello.values["reset"])
        if version != VERSION:
            raise InputError(
                f"The board speaks version {version} of the link, this program {VERSION}: write the firmware again."
            )
        if digest not in (None, hello.values["digest"]):
            raise InputError("The board holds another firmware than this project: write it to the board again.")
        return hello

    @property
    def _token(self) -> int:
        return id(self) % (1 << 32)

    def command(self, name: str, **values: Any) -> None:
        """Send a command and wait until the board executes it.

        Raises:
            SolveError: the board refuses, or does not answer.
        """
        result = self.ask_result(name, **values)
        if result is not BoardAnswer.DONE:
            raise SolveError(f"The board answers `{name}` with: {ANSWERS[result]}.")

    def ask_result(self, name: str, **values: Any) -> BoardAnswer:
        """Send a command and return its result; raise `SolveError` if the board does not answer."""
        answer = self._ask(name, lambda m, number: m.name == "answer" and m.values["to"] == number, **values)
        return BoardAnswer(answer.values["result"])

    def store(self) -> None:
        """Keep the calibration in the EEPROM of a stand-alone board.

        Raises:
            SolveError: the board refuses, or does not finish.
        """
        until = self.now() + LONGEST_STORE
        while self.now() < until:
            if (result := self.ask_result("store")) is BoardAnswer.DONE:
                return
            if result is not BoardAnswer.BUSY:
                raise SolveError(f"The board does not store its calibration: {ANSWERS[result]}.")
        raise SolveError(f"The board has not stored its calibration within {LONGEST_STORE:g} s.")

    def arm(self, word: str) -> None:
        """Allow signals; `word` must be `ARM`, given by a person.

        Raises:
            InputError: another word.
        """
        if word != ARM:
            raise InputError(f"Nothing is armed without the word `{ARM}`, but `{word}` was given.")
        self.command("arm", word=ARM_WORD)

    def disarm(self) -> None:
        """Turn off all signals."""
        self.command("disarm")

    def choose_mode(self, name: str) -> None:
        """Set the source of the signals: `idle`, `loop`, `waveform` or `emulated`.

        Raises:
            InputError: the mode is unknown.
        """
        modes = {mode.name.lower(): mode for mode in Mode}
        if name not in modes:
            raise InputError(f"There is no mode `{name}`. {suggest_name(name, modes)}")
        self.command("mode", mode=int(modes[name]))

    def _read(self) -> list[Message]:
        try:
            return list(self.reader.feed(self.port.read(4096)))
        except OSError as error:
            raise _describe_loss(error) from None

    def _ask(self, name: str, fits: Callable[[Message, int], bool], **values: Any) -> Message:
        for _ in range(TRIES):
            number, until = self.send(name, **values), self.now() + WAIT
            while self.now() < until:
                came = self._read()
                answer = next((one for one in came if fits(one, number)), None)
                self._waiting.extend(one for one in came if one is not answer)
                if answer is not None:
                    return answer
        raise SolveError(
            f"The board does not answer `{name}` ({TRIES} tries in {TRIES * WAIT:g} s): check the cable, the baud "
            "rate, and that the firmware runs."
        )


def _describe_loss(error: OSError) -> SolveError:
    return SolveError(
        f"The line to the board failed ({error}): check the cable, that the board runs, and that no other program uses "
        "the port."
    )


RESETS = {
    ResetCause.UNKNOWN: "an unknown cause",
    ResetCause.POWER_ON: "power-on",
    ResetCause.BROWN_OUT: "a low supply voltage of the processor (brown-out)",
    ResetCause.WATCHDOG: "its watchdog: no sample was made in time",
    ResetCause.PIN: "its reset pin",
    ResetCause.FAULT: "a fault of the processor or an overflow of its stack",
}
ANSWERS = {
    BoardAnswer.UNKNOWN: "it does not know this command",
    BoardAnswer.REFUSED: "not now: the board is not armed, is armed, or is in another mode than this needs",
    BoardAnswer.OUT_OF_RANGE: "the value is outside the range that `export firmware` has printed",
    BoardAnswer.FULL: "there is no room for another level",
    BoardAnswer.BUSY: "the board is still writing",
    BoardAnswer.FIXED: "this number is a constant in flash; change the scenario or an option and export again",
}
