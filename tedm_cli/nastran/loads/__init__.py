"""Unit loads in decks: temperatures of grids and elements, written, read and checked."""
