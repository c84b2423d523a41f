"""What machines know together, and refreshing many of them."""
