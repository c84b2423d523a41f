"""What planners print: predictions, look-ups, stability."""
