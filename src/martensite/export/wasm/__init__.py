"""A scenario as a WebAssembly module with a typed wrapper: one module per part of the folder."""

from __future__ import annotations

from martensite.export.wasm.module import WasmModule, build_wasm

__all__ = ["WasmModule", "build_wasm"]
