"""Speed and accuracy of martensite beside other solvers; run `python -m benchmarks`."""
