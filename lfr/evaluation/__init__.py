"""Rollouts on held-out seeds, the chain of zero-shot links, statistics, tables and figures."""
