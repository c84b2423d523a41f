"""Commands that explain recordings."""
