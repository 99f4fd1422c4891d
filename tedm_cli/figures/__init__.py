"""Arrays to matplotlib figures; the only room that imports matplotlib, and none of it keeps pyplot's state."""
