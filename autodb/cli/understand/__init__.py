"""Commands that explain recordings and what is stored."""
