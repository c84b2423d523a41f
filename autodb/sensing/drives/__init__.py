"""Feed drives: identified from moves, and the load told by their effort."""
