"""Figures of the optical bench and its sensitivity matrix."""
