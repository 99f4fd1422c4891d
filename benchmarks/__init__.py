"""Benchmarks against named peers, growth with the size of models, and goals: `make bench`; `page.py` makes the page."""
