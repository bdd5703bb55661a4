"""Kernels: one source, run as plain floats, NumPy arrays or compiled C.

Kernels are straight-line functions with a `Namespace` as first argument. They are traced once into an expression graph,
and each runtime prints this graph in a separate language.
"""
