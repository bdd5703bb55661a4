"""Batches on a GPU of NVIDIA: the traced kernels as CUDA C, compiled at run time by NVRTC."""
