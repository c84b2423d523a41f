"""Effects in the effort of a feed axis."""
