"""Examples; each folder is run by one command, which its own page or docstring says."""
