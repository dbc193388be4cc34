"""What can go wrong."""

from __future__ import annotations

__all__ = ["GraspError", "IndexFileError", "ParameterError", "PictureError"]


class GraspError(Exception):
    """The base of all errors of this package; each message says what to do."""


class IndexFileError(GraspError):
    """A file is missing, is no sound index, or was changed while it was in use."""


class ParameterError(GraspError, ValueError):
    """A parameter, a query or a vector cannot be; the message says what can."""


class PictureError(GraspError):
    """A picture has no answer.

    Attributes
    ----------
    kind : str
        A short, stable name, as in the programs' records: among others ``no_hand``,
        ``hand_too_small``, ``unreadable``, ``not_an_image``, ``truncated``, ``mask``.
    is_rejection : bool
        Whether the picture is sound, and merely shows no hand that can be recognised.
    """

    def __init__(self, message: str, kind: str = "not_an_image", is_rejection: bool = False) -> None:
        super().__init__(message, kind, is_rejection)
        self.kind = kind
        self.is_rejection = is_rejection

    def __str__(self) -> str:
        return str(self.args[0])
