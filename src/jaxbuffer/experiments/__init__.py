"""Designed experiments: samples of many numbers, whose scatter matters most, a fitted surface, what is safe."""
