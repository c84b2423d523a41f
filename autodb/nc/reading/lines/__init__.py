"""From the text of an NC program to instructions, whatever control it is for."""
