"""Datasets of other projects as LeRobot datasets."""
