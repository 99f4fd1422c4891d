"""Nastran's OP2: Fortran records, the reader of displacements and their frames, and a writer."""
