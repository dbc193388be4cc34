"""Recognise which of six grasps the hand in a picture makes; search indexes of vectors.

`Index` opens an index and searches it for vectors, `build` makes one of vectors, `Recogniser`
answers pictures with an `Answer` each, a `Sequence` those of one hand one after the other, and
`strategy` says what a robot does to make the same grasp. Errors are `GraspError` and its subclasses. The
programs `grasp-builder` and `grasp-query` make indexes of pictures, and do the same on the command
line.
"""

from ._native import Index, Recogniser, Sequence, build
from .answer import Answer
from .errors import GraspError, IndexFileError, ParameterError, PictureError
from .robot import strategy

__all__ = [
    "Answer",
    "GraspError",
    "Index",
    "IndexFileError",
    "ParameterError",
    "PictureError",
    "Recogniser",
    "Sequence",
    "build",
    "strategy",
]

# What is imported from here is shown as from here.
for _thing in (Answer, GraspError, IndexFileError, ParameterError, PictureError, strategy):
    _thing.__module__ = __name__
