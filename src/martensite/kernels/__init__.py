"""Kernels: one source, run as plain floats, NumPy arrays or compiled C.

Kernels are straight-line functions whose first argument is a `Namespace`. They are traced
once into an expression graph, and each runtime prints that graph in its own language.
"""
