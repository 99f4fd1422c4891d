"""Configuration of temperature noise: spectra, areas, tables of thermal nodes."""
