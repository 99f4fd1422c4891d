"""What all figures are drawn with: style, keys, labels, cells, and their specification."""
