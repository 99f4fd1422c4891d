"""What case files and series say: spectra, verdicts, and how sure they are."""
