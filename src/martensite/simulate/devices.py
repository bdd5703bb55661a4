"""Chunks of a batch over the devices of JAX: processor cores, a GPU, or several.

Chunks are dealt out in turn and run side by side, the results are fetched in order. Some chunks
are always under way, so that no device waits for the host; no more than a few are, so that memory
does not grow with the number of variants. A chunk is computed by the same program on every device
of a kind: which device has it changes nothing.

JAX sees a processor as one device unless it is told otherwise before it starts, by the environment
variable `XLA_FLAGS=--xla_force_host_platform_device_count=<cores>`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from martensite.base.errors import ParameterError
from martensite.kernels.jax_setup import jax_namespace
from martensite.simulate.arrays import ArrayGrid, BatchRows

CHUNKS = {"cpu": 256}
"""Variants marched together by kind of device: on a processor the state stays in its cache."""
WIDE_CHUNK = 32_768
"""The same on a device with thousands of lanes, which needs many variants to be busy."""
AHEAD = 2
"""Chunks under way on every device."""


def devices_of(count: int | None = None) -> list[Any]:
    """The first `count` devices of JAX, or all of them.

    Raises:
        ParameterError: there are not as many.
    """
    found = list(jax_namespace().jax.devices())
    if count is None:
        return found
    if not 1 <= count <= len(found):
        kinds = f"{len(found)} device{'s' if len(found) > 1 else ''} of kind {found[0].platform}"
        raise ParameterError(f"The batch is to run on {count} devices, but JAX has {kinds}.")
    return found[:count]


def chunk_for(devices: Sequence[Any]) -> int:
    """Variants marched together on devices of this kind, if nothing else is said."""
    return CHUNKS.get(devices[0].platform, WIDE_CHUNK)


def march_chunks(
    run: Callable[[Any, ArrayGrid], BatchRows], chunks: Iterable[Sequence[Any]], plan: ArrayGrid, devices: Sequence[Any]
) -> Iterator[BatchRows]:
    """March chunk after chunk, each on the next device, and fetch what they give, in order.

    Args:
        run: a jitted march, see `martensite.simulate.arrays.jitted_march`.
        chunks: parameter values of each chunk, made when a device is about to take it.
        plan: the steps.
        devices: the devices that share the chunks.

    Yields:
        The rows of every chunk, as arrays of numpy.
    """
    jax = jax_namespace().jax
    plans = [jax.device_put(plan, device) for device in devices]
    under_way: deque[BatchRows] = deque()
    for k, values in enumerate(chunks):
        if len(under_way) == AHEAD * len(devices):
            yield jax.device_get(under_way.popleft())
        place = k % len(devices)
        under_way.append(run(jax.device_put(list(values), devices[place]), plans[place]))
    while under_way:
        yield jax.device_get(under_way.popleft())
