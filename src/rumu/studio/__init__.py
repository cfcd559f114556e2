"""Attempts, classes, practice, comparisons and jobs. Knows nothing of HTTP."""
