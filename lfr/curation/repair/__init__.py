"""Mending a dataset where its files say what is true, a module for each part of it.

A step is a function that takes a `lfr.curation.repair.draft.Draft`, a dataset made of links to the
original's files, and puts mended files in the place of some of them. What only a guess could mend
raises `Unmendable`, which says why.
"""
