"""The proof on real axes: answers, peers, scores, summary."""
