"""Forces from drive signals by a network that remembers (LSTM); needs the extra `lstm`."""
