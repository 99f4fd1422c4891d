"""Noise as filters driven by white noise: rational fits of spectra, shaping filters, state spaces."""
