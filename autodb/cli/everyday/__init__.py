"""Commands of every day: learn from what came in, predict, look up, serve."""
