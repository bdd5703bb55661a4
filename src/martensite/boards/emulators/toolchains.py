"""Compilers and emulators of boards, if installed.

On Debian: gcc-avr, avr-libc, arduino-core-avr, libsimavr-dev for the Uno; gcc-arm-none-eabi, libnewlib-arm-none-eabi,
qemu-system-arm for the STM32F405. This package contains none of them.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import zlib
from collections.abc import Sequence
from pathlib import Path

from martensite.base.caches import is_private_file
from martensite.base.errors import CompileError, InputError
from martensite.boards.firmware.boards import LARGER, find_board
from martensite.kernels.compiler import find_compiler

CORE = Path("/usr/share/arduino/hardware/arduino/avr")
"""Arduino core for AVR on Debian."""
SIMAVR = Path("/usr/include/simavr/sim_avr.h")
MCUS = {
    "uno": ("atmega328p", "standard", "AVR_UNO"),
    "nano": ("atmega328p", "eightanaloginputs", "AVR_NANO"),
    "mega2560": ("atmega2560", "mega", "AVR_MEGA2560"),
}
"""Processor, variant and name of a board in the Arduino core."""
PACKAGES = {
    "avr-gcc": "gcc-avr and avr-libc",
    "avr-g++": "gcc-avr and avr-libc",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
    "qemu-system-arm": "qemu-system-arm",
}

STACK = 400
"""Assumed least stack of the loop and the link [bytes]."""


def require_tool(name: str) -> str:
    """Return the path of a tool.

    Raises:
        InputError: it is not installed; the message names its Debian packages.
    """
    path = shutil.which(name)
    if path is None:
        raise InputError(f"This needs `{name}`, which is not installed; on Debian: {PACKAGES[name]}.")
    return path


def run_tool(command: Sequence[str | Path], folder: Path) -> None:
    """Run a compiler; raise `CompileError` with its message if it fails."""
    done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CompileError(f"`{Path(command[0]).name}` failed: {done.stderr.strip()[:1500]}")


def compile_sketch(folder: Path, board: str, flags: Sequence[str] = ()) -> Path:
    """Compile a sketch and the Arduino core for an AVR board, and return the ELF file.

    Raises:
        InputError: compiler or core is missing, or the board is not an AVR.
        CompileError: the compiler failed.
    """
    if board not in MCUS:
        raise InputError(f"Only {', '.join(MCUS)} are compiled here; use PlatformIO or the Arduino IDE for `{board}`.")
    plus, core = require_tool("avr-g++"), CORE / "cores" / "arduino"
    if not core.is_dir():
        raise InputError("This needs the Arduino core for AVR; on Debian: arduino-core-avr.")
    mcu, variant, name = MCUS[board]
    common = [
        f"-mmcu={mcu}",
        "-DF_CPU=16000000L",
        "-DARDUINO=10819",
        f"-DARDUINO_{name}",
        "-DARDUINO_ARCH_AVR",
        "-DDECIMAL_DIG=9",
    ]
    common += ["-Os", "-ffunction-sections", "-fdata-sections", "-flto", *flags]
    common += [f"-I{core}", f"-I{CORE / 'variants' / variant}", f"-I{folder}"]
    folder = folder.resolve()
    (sketch,) = folder.glob("*.ino")
    objects = folder / "build"
    objects.mkdir(exist_ok=True)
    run_tool(["avr-gcc", *common, "-std=gnu11", "-c", *core.glob("*.c"), *folder.glob("*.c")], objects)
    words = ["-x", "c++", "-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics", "-include", "Arduino.h"]
    run_tool([plus, *common, *words, "-c", *core.glob("*.cpp"), *folder.glob("*.cpp"), sketch], objects)
    elf = folder / "firmware.elf"
    link = [plus, *common, "-Wl,--gc-sections", *sorted(objects.glob("*.o")), "-lm", "-o", elf]
    try:
        run_tool(link, folder)
    except CompileError as error:
        explain_overflow(str(error), board)
        raise
    check_room(elf, "avr-size", board)
    return elf


def explain_overflow(message: str, board: str) -> None:
    """Raise `InputError` with the missing flash or RAM if a linker reports that a program is too large."""
    match = re.search(r"region .?(text|data).? overflowed by (\d+) bytes", message)
    if match is not None:
        title, room = find_board(board).title, find_board(board).flash
        memory = "flash" if match[1] == "text" else "RAM"
        raise InputError(
            f"This loop does not fit into the {memory} of {title}: it has {int(match[2]):,} bytes too many"
            f"{f' for the {room:,} there are' if memory == 'flash' else ''}. Take {LARGER}."
        ) from None


def read_sizes(tool: str, elf: Path) -> tuple[int, int]:
    """Return flash and static RAM of a program [bytes]."""
    done = subprocess.run([tool, str(elf)], capture_output=True, text=True, check=True)
    text, data, bss, *_ = done.stdout.splitlines()[1].split()
    return int(text) + int(data), int(data) + int(bss)


def check_room(elf: Path, tool: str, board: str) -> None:
    """Raise `InputError` if a program does not fit its board with `STACK` bytes of stack."""
    flash, ram = read_sizes(tool, elf)
    limits = find_board(board)
    if flash > limits.flash or ram + STACK > limits.ram:
        elf.unlink()
        raise InputError(
            f"This loop does not fit {limits.title}: it takes {flash:,} of {limits.flash:,} bytes of flash, and "
            f"{ram:,} of {limits.ram:,} bytes of RAM, of which the stack needs {STACK}. Take {LARGER}."
        )


def compile_bare(folder: Path) -> Path:
    """Compile a project with a Makefile, and return its ELF file.

    Raises:
        InputError: the compiler is missing.
        CompileError: it failed.
    """
    require_tool("arm-none-eabi-gcc")
    run_tool(["make", "-s"], folder)
    return folder / "firmware.elf"


def build_simavr_line(folder: Path) -> Path:
    """Compile the program that runs an AVR under simavr, and return its path.

    Raises:
        InputError: simavr or a compiler is missing.
    """
    cc = find_compiler()
    if cc is None or not SIMAVR.exists():
        raise InputError("This needs a C compiler and simavr; on Debian: libsimavr-dev.")
    source = Path(__file__).with_name("simavr_line.c")
    program = folder.resolve() / f"simavr_line_{zlib.crc32(source.read_bytes()):08x}"
    if not is_private_file(program):
        run_tool([cc, "-O2", source, "-o", program, "-lsimavr", "-lm"], folder)
        program.chmod(0o700)
    return program
