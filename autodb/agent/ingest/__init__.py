"""Files on their way into the database."""
