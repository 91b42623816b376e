"""Gymnasium environments in which arms that are known by their datasets act."""
