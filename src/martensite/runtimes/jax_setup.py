"""JAX, set up once: double precision, and a persistent cache for all our small kernels."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from martensite.runtimes.arrays import ArrayNamespace

# XLA prefers 256-bit vectors; batches gain a third with 512 where the processor has them
WIDE_VECTORS = {"xla_cpu_prefer_vector_width": 512}


@cache
def jax_namespace() -> ArrayNamespace:
    """The kernel operations over JAX arrays; configures JAX on first use.

    The compile cache lies in the user's cache folder; `MARTENSITE_JAX_CACHE` moves it, and
    an empty value switches it off.
    """
    import jax

    jax.config.update("jax_enable_x64", True)
    folder = os.environ.get("MARTENSITE_JAX_CACHE", str(cache_folder() / "jax"))
    if folder:
        jax.config.update("jax_compilation_cache_dir", folder)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return ArrayNamespace(jax.numpy, detach=jax.lax.stop_gradient)


def cache_folder() -> Path:
    """The user's cache folder for this package."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "martensite"

