"""The documentation: pages, figures, and what makes them."""
