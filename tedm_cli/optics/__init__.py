"""Layout, ray trace and its derivative, read-out law, invariances. Pure: arrays in and out, no files."""
