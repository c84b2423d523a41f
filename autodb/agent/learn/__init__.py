"""From sensed forces to a pair's cutting parameters."""
