"""How large a cut may be: the limits of a machine, and stability."""
