"""Datasets and models as others find them: cards, and publishing to the Hub or to a folder."""
