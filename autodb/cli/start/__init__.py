"""Commands that set a database and a machine up, with its first recordings."""
