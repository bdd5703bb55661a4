"""Measurement of resistance on boards: sampling within pulses, timers, circuit.

Source of truth: the wire in the emulator, whose voltages are switched with the pulses; data sheets for clocks.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from firmware_on_host import HostBoard
from typer.testing import CliRunner

import martensite as ms
from martensite.boards.calibration import accept_nominal
from martensite.boards.emulators.rig import EmulatedRig
from martensite.boards.emulators.toolchains import compile_sketch
from martensite.boards.firmware.boards import find_board
from martensite.boards.firmware.channels import plan_inputs
from martensite.boards.firmware.project import Firmware, build_firmware
from martensite.boards.firmware.settings import Limits
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import DisarmReason
from martensite.boards.session import Session
from martensite.cli import app
from martensite.kernels.compiler import find_compiler

EXAMPLES = Path(__file__).parents[2] / "examples"
AVR = shutil.which("avr-g++") and Path("/usr/include/simavr/sim_avr.h").exists()
needs_avr = pytest.mark.skipif(not AVR, reason="gcc-avr, arduino-core-avr or libsimavr-dev are not installed")
needs_cc = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")


def write_resistance_loop(folder: Path, frequency: str = "1 kHz") -> Path:
    """A loop on the resistance of the wire of an example, small enough for an Uno."""
    text = (EXAMPLES / "closed_loop.toml").read_text("utf-8")
    text = text.replace('kind = "position"\ndelay = "20 ms"', 'kind = "resistance"\nrelative_noise = 0.0')
    text = text.replace('measured = "position"', 'measured = "resistance"').replace('"1 kHz"', f'"{frequency}"')
    text = re.sub(r"Kp = .*\nKi = .*\n", "Kp = -0.1\nlow = 0.05\n", text)
    text = re.sub(
        r"\[reference\].*?\n\n", '[reference]\nkind = "constant"\nlevel = "12 ohm"\n\n', text, flags=re.DOTALL
    )
    place = folder / "resistance.toml"
    place.write_text(text, "utf-8")
    return place


def measure_scatter(firmware: Firmware, folder: Path, duty: float) -> tuple[float, float, float]:
    """Scatter of the resistance over itself, its error, and the frequency of the pulses."""
    with Session.open(folder, "emulator") as session:
        assert isinstance(session.port, EmulatedRig)
        accept_nominal(session)
        log = session.play([(0.4, duty)], word="ARM")
        ohms = log.table()[4:18, log.names.index("resistance")]
        truth = session.port.truth["resistance"]
        scatter, error = np.std(np.diff(ohms)) / 2**0.5 / truth, abs(np.mean(ohms) / truth - 1.0)
        return float(scatter), float(error), session.port.board.frequency


@needs_avr
@pytest.mark.parametrize("frequency", [1000.0, 300.0])
def test_resistance_is_read_while_the_switch_is_closed(tmp_path: Path, frequency: float) -> None:
    firmware = build_firmware(ms.load(write_resistance_loop(tmp_path, f"{frequency} Hz")), "uno", name="uno")
    firmware.write(tmp_path / "uno")
    compile_sketch(tmp_path / "uno", "uno")
    for duty in (0.05, 0.3, 1.0) if frequency == 1000.0 else (0.015, 0.6):
        scatter, error, found = measure_scatter(firmware, tmp_path / "uno", duty)
        assert scatter < firmware.plan.inputs.circuit.noise and error < 0.01
        assert abs(found / frequency - 1.0) < 1e-3


@needs_avr
def test_the_rig_shows_sampling_that_ignores_the_pulses(tmp_path: Path) -> None:
    firmware = build_firmware(ms.load(write_resistance_loop(tmp_path)), "uno", name="uno")
    firmware.write(tmp_path / "uno")
    layer = tmp_path / "uno" / "board_arduino.cpp"
    text = layer.read_text("utf-8")
    blind = text.replace("if (!convert_in_pulse(pulses[drive])) return BOARD_SHORT;", "ADCSRA |= _BV(ADSC);")
    assert blind != text
    layer.write_text(blind, "utf-8")
    compile_sketch(tmp_path / "uno", "uno")
    scatter, error, _ = measure_scatter(firmware, tmp_path / "uno", 0.05)  # two conversions do not fit into the pulse
    assert scatter > 0.05 or error > 0.05


HARNESS = """
#include <stdint.h>
#include <stdio.h>
static uint32_t places[64], ticks, read_data;
static volatile uint32_t values[64];
static void pass(void);
/* Registers of a test: the timer and the clock advance by a microsecond with every access. */
static volatile uint32_t *at(uint32_t address) {
    pass();
    if (address == 0x40011004u) ++read_data;
    for (int i = 0; i < 64; ++i) {
        if (places[i] == 0) places[i] = address;
        if (places[i] == address) return values + i;
    }
    return 0;
}
#define AT(address) (*at(address))
#define MASK_INTERRUPTS()
#define ALLOW_INTERRUPTS()
#include "board_stm32f405.c"
void board_tick(void) {}
static uint32_t look(uint32_t address) {
    for (int i = 0; i < 64; ++i)
        if (places[i] == address) return values[i];
    return 0;
}
static void set(uint32_t address, uint32_t value) { *at(address) = value; }
static int busy;
static void pass(void) {
    if (busy) return;
    busy = 1;
    ticks += SLOW / 1000000;
    set(0x40000424u, ticks / PWM_DIVIDER % PWM_STEPS);
    set(0x40012000u, 2u);
    milliseconds = ticks / (SLOW / 1000);
    set(0xe000e018u, PER_MS - 1u - ticks % (SLOW / 1000) * 2u);
    busy = 0;
}
int main(void) {
    board_begin();
    printf("%u %u %u\\n", look(0x40000428u), look(0x4000042cu), look(0x40012304u));
    for (int k = 1; k <= 100; ++k) {
        float steps;
        board_drive(0, 0.01f * (float)k);
        const int found = board_pulse_channel(0, 0, &steps);
        printf("%d %u\\n", found, look(0x40000424u) * PWM_DIVIDER);
    }
    set(0x40011000u, 8u); /* an overrun, no byte */
    read_data = 0;
    USART1_IRQHandler();
    printf("%u %d\\n", read_data, board_read());
    return 0;
}
"""


@needs_cc
@pytest.mark.parametrize("frequency", ["250 Hz", "1 kHz", "20 kHz"])
def test_timer_and_converter_of_an_stm32(tmp_path: Path, frequency: str) -> None:
    firmware = build_firmware(ms.load(EXAMPLES / "closed_loop.toml", {"driver.frequency": frequency}), "stm32f405")
    firmware.write(tmp_path)
    (tmp_path / "harness.c").write_text(HARNESS, "utf-8")
    subprocess.run(["cc", "-std=gnu99", "-O1", "harness.c", "-o", "harness"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "harness"], capture_output=True, text=True, check=True, timeout=60)
    first, *pulses, last = [list(map(int, line.split())) for line in done.stdout.splitlines()]
    divider, top, converter = first
    hertz, circuit = firmware.plan.inputs.frequency, firmware.plan.inputs.circuit
    assert abs(84e6 / ((divider + 1) * (top + 1)) / hertz - 1.0) < 1e-3
    assert 84e6 / (2.0 * (1 + (converter >> 16 & 3))) <= 36e6  # RM0090, and data sheet DS8626, table 67
    for percent, (found, count) in enumerate(pulses, 1):
        length, at = 0.01 * percent / hertz, count / 84e6
        if found == 2:  # the conversion starts settled, and holds its input before the switch opens
            assert circuit.settle - 1e-6 <= at <= length
        else:
            assert length < circuit.pulse + 1e-6
    assert last == [1, -1]


def test_circuits_that_cannot_be_built_are_refused(tmp_path: Path) -> None:
    for board, changes, words in (
        ("uno", {"driver.supply": "230 V"}, "extra-low voltage"),
        ("uno", {"driver.supply": "60 V"}, "measures at most 55 V"),
        ("uno", {"driver.frequency": "40 Hz"}, "50 to 62500 Hz"),
        ("stm32f405", {"driver.frequency": "1 MHz"}, "write a frequency in this range"),
    ):
        bench = ms.load(EXAMPLES / "closed_loop.toml", changes).bench
        with pytest.raises(ms.InputError, match=words):
            plan_inputs(bench, find_board(board))  # type: ignore[arg-type]
    bench = ms.load(EXAMPLES / "self_sensing.toml", {"driver.frequency": "1 kHz"}).bench
    with pytest.raises(ms.InputError, match=r"`driver\.frequency` of at most 387 Hz"):
        plan_inputs(bench, find_board("stm32f405"))  # type: ignore[arg-type]
    with pytest.raises(ms.InputError, match="cannot convert within a pulse"):
        plan_inputs(bench, find_board("esp32"))  # type: ignore[arg-type]
    words = ["export", "firmware", str(EXAMPLES / "closed_loop_sensorless.toml"), "--board", "uno"]
    done = CliRunner().invoke(app, [*words, "--out", str(tmp_path / "uno")])
    assert done.exit_code == 2 and "use a larger board" in " ".join(done.stderr.split())
    assert not (tmp_path / "uno").exists()


def test_readings_of_the_calibration_count() -> None:
    """The probing current of a pulse is the full current, above the least current of the firmware."""
    plan = build_firmware(ms.load(EXAMPLES / "self_sensing.toml"), "stm32f405").plan
    least = next(one.value for one in plan.settings if one.name == "least_current")
    assert plan.inputs.least_duty < 0.01 and least < 0.5 * plan.inputs.largest_current  # it probes with 0.01 and 0.02


TWO_WIRES = """
[sensors.left]
kind = "resistance"
of = ["protagonist.voltage", "protagonist.current"]
[sensors.right]
kind = "resistance"
of = ["antagonist.voltage", "antagonist.current"]
[controllers.protagonist]
kind = "pid"
measured = "left"
Kp = -0.01
[controllers.antagonist]
kind = "pid"
measured = "right"
Kp = -0.01
[references]
protagonist = { kind = "constant", level = "45 ohm" }
antagonist = { kind = "constant", level = "45 ohm" }
"""


@needs_cc
def test_too_large_a_current_in_any_wire_disarms(tmp_path: Path) -> None:
    text = (EXAMPLES / "closed_loop_antagonistic.toml").read_text("utf-8")
    text = text.replace('kind = "power"', 'kind = "mosfet"\nsupply = "12 V"\nfrequency = "500 Hz"')
    text = re.sub(r"\[sensor\].*(?=\[supervisor\])", lambda _: TWO_WIRES, text, flags=re.DOTALL)
    text = re.sub(r"\[supervisor\].*(?=\[bench\])", "", text, flags=re.DOTALL)
    (tmp_path / "two.toml").write_text(text, "utf-8")
    scenario = ms.load(tmp_path / "two.toml")
    board = HostBoard(build_firmware(scenario, "uno", limits=Limits(silence=20.0)), tmp_path)
    board.set_channel(4, 1023.0)  # the supply
    link = BoardLink(board, now=board.now)
    link.greet()
    link.command("set", place=4, value=1.0)  # calibrated
    link.choose_mode("waveform")
    link.arm("ARM")
    for channel in (1, 3):
        for drive in (0, 1):
            link.command("level", drive=drive, micros=10_000_000, value=0.5)
        board.run(0.2)
        assert not [m for m in link.receive() if m.name == "disarmed"]
        board.set_channel(channel, 1023.0)
        reasons = [m.values["reason"] for _ in range(200) for m in link.receive() if m.name == "disarmed"]
        assert reasons == [DisarmReason.CURRENT] and board.duty(0) == board.duty(1) == 0.0
        board.set_channel(channel, 0.0)
        link.choose_mode("waveform")
        link.arm("ARM")
    with pytest.raises(ms.InputError, match="the wiring measures at most"):
        build_firmware(scenario, "uno", limits=Limits(current=20.0))
