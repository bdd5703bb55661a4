"""Export of a scenario as a WebAssembly module with a typed wrapper."""

from __future__ import annotations

from martensite.export.wasm.module import WasmModule, build_wasm

__all__ = ["WasmModule", "build_wasm"]
