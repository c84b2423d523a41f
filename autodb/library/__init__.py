"""What `import autodb` gives: a database, its machines and their answers, with data frames."""
