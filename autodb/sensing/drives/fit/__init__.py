"""The fit of an axis' terms."""
