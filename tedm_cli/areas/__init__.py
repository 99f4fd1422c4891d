"""Thermal areas: the grids that make them, proven to be a partition, and their attributes."""
