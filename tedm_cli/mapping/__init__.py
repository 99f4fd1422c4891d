"""Temperatures of grids from those of thermal nodes, by averages that are kept and the conduction between; pure."""
