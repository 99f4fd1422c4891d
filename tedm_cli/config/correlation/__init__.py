"""Configuration of the correlation of temperatures."""
