"""Variants of a design by several criteria: which dominates which, in what order they stand, what has changed. Pure."""
