"""The evidence of docs/evidence.md: every run of it in one table, `results/evidence/runs.csv`."""
