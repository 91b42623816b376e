"""What can be wrong with a dataset, a module for each family of checks.

A check is a function that takes the `lfr.curation.contents.Contents` of a dataset and yields a
`lfr.curation.finding.Finding` for each thing that is wrong. What it cannot read raises
`Unreadable`, which says why.
"""
