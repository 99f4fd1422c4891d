"""Decks of millions of cards: the numerous ones as columns without an object each, the others through pyNastran."""
