"""Corners of tolerances: which are worst, and which tolerance matters."""
