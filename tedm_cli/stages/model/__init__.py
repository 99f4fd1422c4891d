"""From decks and areas to [D]: areas, write-deck, solve, ingest, build-distortion."""
