"""Compilers and emulators of boards, where the system has them; firmware compiled by them.

On Debian: gcc-avr, avr-libc, arduino-core-avr, libsimavr-dev for the Uno; gcc-arm-none-eabi, libnewlib-arm-none-eabi,
qemu-system-arm for the STM32F405. Nothing of them is part of this package.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from martensite.base.errors import CompileError, InputError
from martensite.kernels.compiler import find_compiler

CORE = Path("/usr/share/arduino/hardware/arduino/avr")
"""Where Debian keeps the Arduino core for AVR."""
MCUS = {"uno": ("atmega328p", "standard", "AVR_UNO"), "mega2560": ("atmega2560", "mega", "AVR_MEGA2560")}
"""Processor, variant and name of a board in the Arduino core."""
PACKAGES = {
    "avr-gcc": "gcc-avr and avr-libc",
    "avr-g++": "gcc-avr and avr-libc",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
    "qemu-system-arm": "qemu-system-arm",
}


def require_tool(name: str) -> str:
    """Where a tool is.

    Raises:
        InputError: it is not installed; the sentence names its packages on Debian.
    """
    found = shutil.which(name)
    if found is None:
        raise InputError(f"This needs `{name}`, which is not installed; on Debian: {PACKAGES[name]}.")
    return found


def run_tool(command: Sequence[str | Path], folder: Path) -> None:
    """Run a compiler; `CompileError` with what it says if it fails."""
    done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CompileError(f"`{Path(command[0]).name}` failed: {done.stderr.strip()[:1500]}")


def compile_sketch(folder: Path, board: str, flags: Sequence[str] = ()) -> Path:
    """Compile a sketch and the Arduino core for an AVR board; the ELF file, in the folder.

    Raises:
        InputError: compiler or core are missing, or the board is no AVR.
        CompileError: the compiler failed.
    """
    if board not in MCUS:
        raise InputError(
            f"Only {' and '.join(MCUS)} are compiled here; use PlatformIO or the Arduino IDE for `{board}`."
        )
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
    run_tool([plus, *common, "-Wl,--gc-sections", *sorted(objects.glob("*.o")), "-lm", "-o", elf], folder)
    return elf


def compile_bare(folder: Path) -> Path:
    """Compile a project with a Makefile; its ELF file.

    Raises:
        InputError: the compiler is missing.
        CompileError: it failed.
    """
    require_tool("arm-none-eabi-gcc")
    run_tool(["make", "-s"], folder)
    return folder / "firmware.elf"


def build_simavr_line(folder: Path) -> Path:
    """Compile the program that holds an AVR under simavr by its line and clock; its path.

    Raises:
        InputError: simavr or a compiler is missing.
    """
    cc = find_compiler()
    if cc is None or not Path("/usr/include/simavr/sim_avr.h").exists():
        raise InputError("This needs a C compiler and simavr; on Debian: libsimavr-dev.")
    found = folder.resolve() / "simavr_line"
    if not found.exists():
        source = Path(__file__).with_name("simavr_line.c")
        run_tool([cc, "-O2", source, "-o", found, "-lsimavr"], folder)
    return found
