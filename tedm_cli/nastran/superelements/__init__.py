"""Matrices of reduced structures: DMIG and OUTPUT4 in and out, and those that a deck selects."""
