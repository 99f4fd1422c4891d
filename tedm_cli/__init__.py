"""Thermo-elastic distortion modelling for drag-free satellites."""

__version__ = "1.0.0"
