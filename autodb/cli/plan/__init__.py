"""Commands that answer before a cut is made."""
