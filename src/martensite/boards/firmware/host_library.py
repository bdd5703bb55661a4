"""C library for the host of a board: `host.c` with the link and the description of one firmware."""

from __future__ import annotations

import json
from importlib.resources import files

from martensite.boards.firmware.settings import FirmwarePlan
from martensite.boards.link.host import find_stale
from martensite.boards.link.messages import print_header

FOLDER = "host"
"""Folder in a project; the Arduino IDE does not compile it."""
SOURCES = ("host.c", "host.h", "example.c", "link.c", "link.h")


def print_host_library(plan: FirmwarePlan) -> dict[str, str]:
    """Return the texts of the library by path in a project."""
    home = files("martensite.boards") / "c"
    texts = {name: (home / name).read_text("utf-8") for name in SOURCES}
    texts |= {"messages.h": print_header(), "firmware.h": print_firmware_header(plan), "Makefile": _MAKEFILE}
    return {f"{FOLDER}/{name}": text for name, text in texts.items()}


def print_firmware_header(plan: FirmwarePlan) -> str:
    """Return `firmware.h`: digest, line, and names of telemetry and settings."""
    values, settings = plan.telemetry(), plan.settings
    rows = [
        "/* Firmware of this project, printed by martensite. */",
        "#ifndef FIRMWARE_H",
        "#define FIRMWARE_H",
        "",
        f"#define FIRMWARE_DIGEST {plan.digest:#010x}UL",
        f"#define FIRMWARE_BAUD {plan.board.baud}",
        f"#define FIRMWARE_STALE {find_stale(plan.period):.9g} /* s */",
        f"enum {{ FIRMWARE_VALUES = {len(values)}, FIRMWARE_SETTINGS = {len(settings)} }};",
        "",
        "static const char *const firmware_values[] = {",
        *(f"    {json.dumps(name)}, /* {unit} */" for name, unit in values),
        "};",
        "static const char *const firmware_settings[] = {",
        *(f"    {json.dumps(one.name)}, /* {one.unit} */" for one in settings),
        "};",
        "",
        "#endif",
        "",
    ]
    return "\n".join(rows)


_MAKEFILE = """# make: example, with the host library
CFLAGS = -std=c99 -O2 -Wall -Wextra

example: example.c host.c link.c host.h link.h messages.h firmware.h
\t$(CC) $(CFLAGS) example.c host.c link.c -o $@
"""
