"""Text tables as loggers write them: what separates, what is above the rows, what is no row."""
