"""The evidence: many seeds, every method, both rewards; the stages of paper/dvc.yaml."""
