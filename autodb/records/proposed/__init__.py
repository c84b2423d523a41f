"""Which column of an unknown file is which channel: by its name, and by what it does."""
