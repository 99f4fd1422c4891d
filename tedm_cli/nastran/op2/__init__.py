"""Nastran's OP2: Fortran records, the reader of displacement tables, and a writer."""
