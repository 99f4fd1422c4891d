"""Matrices with labels and units in files that other programs read and write: CSV, NumPy's NPZ, MATLAB's MAT."""
