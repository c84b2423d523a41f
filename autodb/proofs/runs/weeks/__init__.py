"""A lathe's weeks: every file of cuts predicted before it comes in, and the events that are named."""
