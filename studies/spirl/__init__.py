"""SPiRL (Pertsch et al. 2021), a baseline: skills and a prior of the target's own common tasks."""
