"""Temperature spectra, correlation, propagation, bounds, requirements, contributors. Pure: arrays in and out."""
