"""What two datasets have in common and what not: their episodes, features, statistics, and leaks.

Episodes are found again by what is in them, whatever their number and the file that they lie in.
"""
