"""What is asked of a machine: look-ups, predictions, plans, explanations, traces."""
