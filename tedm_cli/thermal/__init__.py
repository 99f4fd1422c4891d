"""The thermal network: steady state, transfer functions, spectra, steps in time. Arrays in, arrays out."""
