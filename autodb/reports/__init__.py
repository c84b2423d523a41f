"""Pages that are read: one shell, one file a report."""
