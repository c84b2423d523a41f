"""The pages that a browser shows, each a question that somebody in the shop has."""
