"""Other ways to identify a feed axis, beside `autodb identify`."""
