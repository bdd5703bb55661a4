"""Run the benchmark of controllers: `python -m benchmarks.control`."""

from benchmarks.control.commands import benchmark

benchmark(prog_name="python -m benchmarks.control")
