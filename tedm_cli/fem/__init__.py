"""Elements, constraints and the linear static solver. Pure: NumPy and SciPy arrays in and out, no files."""
