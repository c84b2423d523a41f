"""Files on the disk: what they hold, and how they are replaced."""
