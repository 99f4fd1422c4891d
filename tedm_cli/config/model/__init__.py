"""Configuration of the model: decks, results, areas, test masses, blocks."""
