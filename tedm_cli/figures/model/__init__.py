"""Figures on the finite-element model, its mesh and its thermal areas."""
