"""Masses in boxes that bring the field at rest within its limits: linear and mixed-integer programmes."""
