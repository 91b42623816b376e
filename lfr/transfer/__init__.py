"""Transfer learning: a policy mapped from the source arm improves on the target (Algorithm 2)."""
