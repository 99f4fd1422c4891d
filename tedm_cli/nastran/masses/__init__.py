"""Masses of Nastran's elements and concentrated mass cards."""
