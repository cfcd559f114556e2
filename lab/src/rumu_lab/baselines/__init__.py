"""Other ways to mark a copy, to be measured beside ours: five published methods and simple ones.

The publications were read as abstracts and opening pages only. Each module says which of its steps are known
from there and which are our reconstruction; where a method gave no grade, the grade is ours. None of them
is what its authors ran, so none may be called by the name alone: "MBSE-based grader (our reconstruction)".
"""
