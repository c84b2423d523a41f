"""Virtual mills, their cuts and the dynamometer on their table."""
