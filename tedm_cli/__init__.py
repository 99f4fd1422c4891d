"""Thermo-elastic distortion modelling for drag-free satellites."""

__version__ = "0.1.0"
