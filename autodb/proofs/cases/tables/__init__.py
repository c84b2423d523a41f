"""Cases made of published tables of cutting forces: effects left out, and injected."""
