"""What cases of every kind share: effects on a recording, noise, moves."""
