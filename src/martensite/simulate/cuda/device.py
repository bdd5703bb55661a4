"""Access to the GPU driver and to the compiler NVRTC through NVIDIA's `cuda-bindings`.

Compiled programs are cached. NVRTC needs neither a driver nor a device.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from martensite.base.caches import is_private_file, keep_private, make_cache
from martensite.base.errors import CompileError, InputError, MartensiteError
from martensite.base.lazy import import_extra, write_install_line
from martensite.simulate.cuda.source import THREADS

ELSE = "use the runtime `c` (or `floats`)"
FLAGS = ("--std=c++17", "--fmad=true", "-diag-suppress=550")
"""Compiler flags: fused products and sums, otherwise exact IEEE 754."""
SHARE = 0.8
"""Fraction of the free memory that is used for arrays."""


class DeviceError(MartensiteError, RuntimeError):
    """Error of the driver, NVRTC or the device, with its name."""

    def __init__(self, name: str) -> None:
        super().__init__(f"The GPU failed ({name}); {ELSE}.")
        self.name = name


class Device(NamedTuple):
    """The first CUDA device."""

    driver: Any
    context: Any
    name: str
    capability: int
    """Compute capability of the device, such as 90."""


@cache
def open_device() -> Device:
    """Return the first CUDA device.

    Raises:
        InputError: no device or driver exists, or the extra `cuda` is not installed.
    """
    driver = import_extra("cuda.bindings.driver", "cuda", "`cuda-bindings`")
    try:
        take_answer(driver.cuInit(0))
        if not take_answer(driver.cuDeviceGetCount()):
            raise DeviceError("the driver lists none")
        device = take_answer(driver.cuDeviceGet(0))
        attributes = driver.CUdevice_attribute
        major = take_answer(
            driver.cuDeviceGetAttribute(attributes.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, device)
        )
        minor = take_answer(
            driver.cuDeviceGetAttribute(attributes.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, device)
        )
        name = take_answer(driver.cuDeviceGetName(128, device)).split(b"\0")[0].decode()
        context = take_answer(driver.cuDevicePrimaryCtxRetain(device))
    except RuntimeError as error:  # also the error of a missing driver
        reason = error.name if isinstance(error, DeviceError) else "there is no NVIDIA driver"
        raise InputError(f"No CUDA device was found ({reason}); {ELSE}.") from None
    return Device(driver, context, name, 10 * major + minor)


def take_answer(answer: tuple[Any, ...]) -> Any:
    """Return the results of a driver or NVRTC call; raise an error for a bad status.

    Raises:
        DeviceError: the call failed.
    """
    status, *rest = answer
    if int(status) != 0:
        raise DeviceError(status.name)
    return rest[0] if len(rest) == 1 else tuple(rest)


# ---------------------------------------------------------------- compiling


def list_architectures() -> list[int]:
    """Return the compute capabilities that NVRTC compiles for, without minor letters."""
    return sorted(take_answer(_load_nvrtc().nvrtcGetSupportedArchs()))


def choose_target(capability: int, architectures: Iterable[int]) -> str:
    """Return the target of NVRTC: machine code for the device, or PTX for a newer device.

    Raises:
        InputError: NVRTC no longer supports the device.
    """
    older = [one for one in architectures if one <= capability]
    if not older:
        raise InputError(
            f"The CUDA device has compute capability {capability / 10:.1f}, which the installed NVRTC no longer "
            f"compiles for; {ELSE}."
        )
    return f"{'sm' if max(older) == capability else 'compute'}_{max(older)}"


def compile_source(text: str, target: str, more: Sequence[str] = ()) -> bytes:
    """Compile a source to machine code, or to PTX for a target `compute_*`.

    Raises:
        CompileError: the compilation failed.
        InputError: NVRTC is not installed.
    """
    nvrtc = _load_nvrtc()
    options = [f"--gpu-architecture={target}", *FLAGS, *more]
    program = take_answer(nvrtc.nvrtcCreateProgram(text.encode(), b"march.cu", 0, [], []))
    try:
        status = nvrtc.nvrtcCompileProgram(program, len(options), [one.encode() for one in options])[0]
        if int(status) != 0:
            log = b" " * take_answer(nvrtc.nvrtcGetProgramLogSize(program))
            take_answer(nvrtc.nvrtcGetProgramLog(program, log))
            raise CompileError(f"NVRTC failed: {log.decode().strip()[:500]}")
        kind = "CUBIN" if target.startswith("sm_") else "PTX"
        binary = b" " * take_answer(getattr(nvrtc, f"nvrtcGet{kind}Size")(program))
        take_answer(getattr(nvrtc, f"nvrtcGet{kind}")(program, binary))
    finally:
        nvrtc.nvrtcDestroyProgram(program)
    return binary


@cache
def _load_nvrtc() -> Any:
    nvrtc = import_extra("cuda.bindings.nvrtc", "cuda", "`cuda-bindings`")
    try:
        take_answer(nvrtc.nvrtcVersion())
    except RuntimeError:
        raise InputError(f"NVRTC was not found; run `{write_install_line('cuda')}`.") from None
    return nvrtc


def _compile_once(text: str, target: str, more: tuple[str, ...]) -> bytes:
    """Compile a source, and cache the result if the folder is writable."""
    key = repr((text, target, FLAGS, more, take_answer(_load_nvrtc().nvrtcVersion())))
    path: Path | None = None
    with suppress(OSError):
        path = make_cache("cuda") / f"{hashlib.sha256(key.encode()).hexdigest()[:24]}.bin"
        content = path.read_bytes()
        if is_private_file(path) and hashlib.sha256(content[32:]).digest() == content[:32]:
            return content[32:]
    binary = compile_source(text, target, more)
    with suppress(OSError):
        if path is not None:
            part = path.with_suffix(f".{os.getpid()}")
            part.write_bytes(hashlib.sha256(binary).digest() + binary)
            keep_private(part, path)
    return binary


# ---------------------------------------------------------------- running


class Resources(NamedTuple):
    """Resources that a kernel uses on the device."""

    registers: int
    """Registers per thread."""
    stack: int
    """Local memory per thread [bytes]."""
    threads: int
    """Threads per multiprocessor."""


class DeviceProgram:
    """Compiled CUDA C on the device."""

    def __init__(self, text: str, more: tuple[str, ...] = ()) -> None:
        self.device = open_device()
        target = choose_target(self.device.capability, list_architectures())
        code = _compile_once(text, target, more)
        driver = self.device.driver
        take_answer(driver.cuCtxSetCurrent(self.device.context))
        self._module = take_answer(driver.cuModuleLoadData(code))
        self._clock = take_answer(driver.cuEventCreate(0)), take_answer(driver.cuEventCreate(0))
        self.seconds = 0.0
        """Duration of the last launch, without copies."""

    def locate(self, name: str) -> int:
        """Return the address of a variable."""
        return int(take_answer(self.device.driver.cuModuleGetGlobal(self._module, name.encode()))[0])

    def launch(self, name: str, threads: int, arguments: Sequence[ctypes.c_int | ctypes.c_longlong]) -> None:
        """Run a kernel in the given number of threads and wait for its end."""
        driver = self.device.driver
        packed = tuple(one.value for one in arguments), tuple(type(one) for one in arguments)
        take_answer(driver.cuEventRecord(self._clock[0], 0))
        take_answer(
            driver.cuLaunchKernel(self._find(name), -(-threads // THREADS), 1, 1, THREADS, 1, 1, 0, 0, packed, 0)
        )
        take_answer(driver.cuEventRecord(self._clock[1], 0))
        take_answer(driver.cuCtxSynchronize())
        self.seconds = 1e-3 * take_answer(driver.cuEventElapsedTime(*self._clock))

    def measure(self, name: str) -> Resources:
        """Return the resources of a kernel."""
        driver, kinds, kernel = self.device.driver, self.device.driver.CUfunction_attribute, self._find(name)
        registers = take_answer(driver.cuFuncGetAttribute(kinds.CU_FUNC_ATTRIBUTE_NUM_REGS, kernel))
        stack = take_answer(driver.cuFuncGetAttribute(kinds.CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES, kernel))
        blocks = take_answer(driver.cuOccupancyMaxActiveBlocksPerMultiprocessor(kernel, THREADS, 0))
        return Resources(registers, stack, THREADS * blocks)

    def _find(self, name: str) -> Any:
        return take_answer(self.device.driver.cuModuleGetFunction(self._module, name.encode()))


class DeviceMemory:
    """Arrays on the device within a `with` block."""

    def __init__(self) -> None:
        self.device = open_device()
        self._addresses: list[int] = []

    def __enter__(self) -> DeviceMemory:
        take_answer(self.device.driver.cuCtxSetCurrent(self.device.context))
        return self

    def __exit__(self, *_: object) -> None:
        while self._addresses:
            self.device.driver.cuMemFree(self._addresses.pop())

    def count_free(self) -> int:
        """Return the bytes available for arrays, with a reserve for the driver."""
        return int(SHARE * take_answer(self.device.driver.cuMemGetInfo())[0])

    def take(self, size: int, fill: int | None = None) -> int:
        """Return the address of new memory [bytes], filled with `fill` if given."""
        place = int(take_answer(self.device.driver.cuMemAlloc(max(size, 1))))
        self._addresses.append(place)
        if fill is not None and size:
            take_answer(self.device.driver.cuMemsetD8(place, fill, size))
        return place

    def give(self, array: Any) -> int:
        """Return the address of a copy of an array."""
        place = self.take(array.nbytes)
        if array.nbytes:
            take_answer(self.device.driver.cuMemcpyHtoD(place, array.ctypes.data, array.nbytes))
        return place

    def move(self, source: int, target: int, size: int) -> None:
        """Copy bytes from address to address."""
        if size:
            take_answer(self.device.driver.cuMemcpyDtoD(target, source, size))

    def fetch(self, place: int, array: Any) -> None:
        """Copy memory at an address into an array."""
        if array.nbytes:
            take_answer(self.device.driver.cuMemcpyDtoH(array.ctypes.data, place, array.nbytes))
