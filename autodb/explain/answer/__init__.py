"""What an explanation says."""
