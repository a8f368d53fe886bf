"""Fits of a design's numbers to measured tests (docs/fit.md)."""
