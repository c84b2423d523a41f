"""What the forces of a table of cuts hold that their simulation does not."""
