"""Commands that keep a database sound, and fleets."""
