"""Commands by which a machine learns."""
