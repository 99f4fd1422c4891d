"""The model as one interactive page: what is drawn of it, packed small, and the page's own program beside it."""
