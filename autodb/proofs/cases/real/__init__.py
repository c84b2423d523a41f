"""Recordings of real axes, and what is concealed in them; physics of their own."""
