"""The part of Nastran that the embedded solver understands, read from a unit-load deck."""
