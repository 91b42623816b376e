"""What `lfr verify` finds, for people: a page with pictures, and a summary for a pull request.

Whatever stands in a dataset may have been written by anybody: no word of it reaches a page or a
summary but through `lfr.curation.report.words`.
"""
