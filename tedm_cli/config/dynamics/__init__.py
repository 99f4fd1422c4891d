"""Configuration of the drag-free dynamics."""
