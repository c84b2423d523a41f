"""Commands for those who change the program."""
