"""Tables of turning cuts with hidden effects."""
