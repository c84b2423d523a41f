"""What is claimed, tried on virtual machines whose truth is known: machines, cases, runs."""
