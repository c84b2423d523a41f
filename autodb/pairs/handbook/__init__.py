"""What handbooks, papers and tool makers say of work materials."""
