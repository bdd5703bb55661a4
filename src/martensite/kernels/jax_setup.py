"""JAX, set up once: double precision, and a persistent cache for all our small kernels."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from martensite.base.caches import make_cache, make_private_folder
from martensite.base.errors import MartensiteError
from martensite.base.files import tell_once
from martensite.kernels.arrays import ArrayNamespace

# XLA prefers 256-bit vectors; batches gain a third with 512 where the processor has them
WIDE_VECTORS = {"xla_cpu_prefer_vector_width": 512}


class JaxNamespace(ArrayNamespace):
    """The kernel operations over JAX arrays, and the configured `jax` itself."""

    def __init__(self, jax: Any) -> None:
        detach, implicit_root = jax.lax.stop_gradient, _make_implicit_root(jax)
        super().__init__(jax.numpy, detach=detach, repeat=self.loop, implicit_root=implicit_root, iterate=self.until)
        self.jax = jax

    def loop(self, count: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        """One loop of the compiler, over states of the shape that the body makes of them."""
        now = self._of_shape(body, state)

        def turn(_: Any, now: Sequence[Any]) -> list[Any]:
            return self._match_shapes(body(*now), now, [n.shape for n in now])

        return self.jax.lax.fori_loop(0, count, turn, now)

    def until(self, most: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        """The same, until the first number is nowhere above 0; where it is not, all stays."""
        now = self._of_shape(body, state)
        shapes = [self.np.broadcast_shapes(n.shape, now[0].shape) for n in now]
        now = self._match_shapes(now, now, shapes)

        def goes_on(carry: Any) -> Any:
            count, now = carry
            return self.np.logical_and(count < most, self.np.any(now[0] > 0.0))

        def turn(carry: Any) -> Any:
            count, now = carry
            going = now[0] > 0.0
            found = self._match_shapes(body(*now), now, [n.shape for n in now])
            kept = [self.np.where(going, a, b) for a, b in zip(found, now, strict=True)]
            return count + 1, kept

        return self.jax.lax.while_loop(goes_on, turn, (0, now))[1]

    def _of_shape(self, body: Callable[..., Sequence[Any]], state: Sequence[Any]) -> list[Any]:
        """A state of the shapes and types that the body makes of it."""
        now: list[Any] = list(state)
        for _ in range(len(state) + 1):
            made, before = self.jax.eval_shape(body, *now), [self.np.shape(v) for v in now]
            pairs = zip(before, made, strict=True)
            shapes = [self.np.broadcast_shapes(s, m.shape) for s, m in pairs]
            now = self._match_shapes(now, made, shapes)
            if shapes == before:
                break
        return now

    def _match_shapes(self, values: Sequence[Any], like: Sequence[Any], shapes: Any) -> list[Any]:
        """Arrays of given shapes, each of the type of another."""
        rows = zip(values, like, shapes, strict=True)
        return [self.np.broadcast_to(v, shape).astype(m.dtype) for v, m, shape in rows]


def _make_implicit_root(jax: Any) -> Any:
    """A function (root, newton) whose value is the root and whose slopes are those of `newton`."""

    def implicit_root(root: Any, newton: Any) -> Any:
        shape = jax.numpy.broadcast_shapes(jax.numpy.shape(root), jax.numpy.shape(newton))
        return marked(*(jax.numpy.broadcast_to(x, shape) for x in (root, newton)))

    def root(found: Any, newton: Any) -> Any:
        return found

    def slopes(values: Any, tangents: Any) -> tuple[Any, Any]:
        return marked(*values), tangents[1]

    marked = jax.custom_jvp(root)
    marked.defjvp(slopes)
    return implicit_root


def has_jax() -> bool:
    """Whether JAX is installed; it is not imported."""
    return find_spec("jax") is not None


@cache
def jax_namespace() -> JaxNamespace:
    """The kernel operations over JAX arrays; configures JAX on first use.

    The compile cache lies in the user's cache folder; `MARTENSITE_JAX_CACHE` moves it, and
    an empty value switches it off.

    Raises:
        MartensiteError: JAX is not installed.
    """
    try:
        jax: Any = import_module("jax")
    except ImportError:
        raise MartensiteError(
            "JAX is not installed; install it with `pip install 'martensite[jax]'`, or take the runtime `c` or "
            "`floats`."
        ) from None
    jax.config.update("jax_enable_x64", True)
    folder = _find_cache()
    if folder:
        jax.config.update("jax_compilation_cache_dir", folder)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return JaxNamespace(jax)


def _find_cache() -> str:
    """The folder of what JAX compiles; empty if it is to keep nothing, or cannot."""
    folder = os.environ.get("MARTENSITE_JAX_CACHE")
    try:
        folder = str(make_cache("jax")) if folder is None else folder
        if folder:
            make_private_folder(Path(folder))
            tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        reason = error.strerror or error
        tell_once(
            f"Warning: what JAX compiles cannot be kept in the cache folder ({reason}); "
            "it is made anew in every process. Name another folder in XDG_CACHE_HOME or MARTENSITE_JAX_CACHE."
        )
        return ""
    return folder


def make_storing_namespace(xp: JaxNamespace, one: Any) -> ArrayNamespace:
    """The namespace whose `store` divides by a number `one` the compiler does not know.

    XLA repeats cheap arithmetic wherever a value is used, but never a division: this keeps
    much-used values in memory and halves the time of a batch.
    """

    def store(x: Any) -> Any:
        return x / one

    return ArrayNamespace(xp.np, xp.detach, store, str(one.dtype), xp.repeat, xp.implicit_root, xp.iterate)
