"""Figures of the thermal network."""
