"""Pictures that notebooks show."""

from __future__ import annotations

import os

import numpy as np

from . import _native


class Picture(np.ndarray):
    """An array of rows, columns and colours (uint8) that a notebook shows as an image."""

    def to_png(self) -> bytes:
        """Returns the picture as a PNG file."""
        return _native._png(np.ascontiguousarray(self, dtype=np.uint8))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture to a PNG file."""
        with open(path, "wb") as file:
            file.write(self.to_png())

    def _repr_png_(self) -> bytes | None:
        # A part or the result of a calculation need not be a picture any longer.
        return self.to_png() if self.ndim == 3 and self.shape[2] == 3 and self.dtype == np.uint8 else None
