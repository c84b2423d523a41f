"""A virtual lathe with physics of its own; it shares no code with the estimators."""
