"""Recorded episodes: MCAP logs, LeRobot datasets packed from them, and windows for training."""
