"""Datasets and logs that can be trusted: verified, replayed, mended, and edited without loss."""
