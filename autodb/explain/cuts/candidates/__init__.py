"""Effects that a table of cuts may hold."""
