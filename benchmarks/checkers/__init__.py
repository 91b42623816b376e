"""How many planted faults checkers of datasets find: `python -m benchmarks.checkers`."""
