"""The proof on published tables of forces: answers, a peer, summary."""
