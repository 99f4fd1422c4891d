"""Figures of correlation cases: spectra, ratios, contributors, and how sure they are."""
