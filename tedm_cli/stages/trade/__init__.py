"""Trade of variants: their projects, what is read of their results, trade.h5, and the page."""
