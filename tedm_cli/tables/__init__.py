"""Users' tables of numbers in CSV and HDF5, read in blocks and refused by file and line."""
