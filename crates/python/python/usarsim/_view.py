"""The live page of a world."""

from __future__ import annotations

import html
import webbrowser
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._native import World


class View:
    """A page that shows a world while it is stepped. A notebook shows it as a frame.

    It is served on this machine alone. Nobody can drive or change the world from it.
    """

    def __init__(self, world: World, url: str, height: int) -> None:
        self._world = world
        self.url = url
        """Address of the page."""
        self.height = height
        """Height of the frame in a notebook, pixels."""

    def open(self) -> None:
        """Opens the page in a browser."""
        webbrowser.open(self.url)

    def close(self) -> None:
        """Ends the page."""
        self._world._hide()

    def _repr_html_(self) -> str:
        url = html.escape(self.url, quote=True)
        return f'<iframe src="{url}" width="100%" height="{self.height}" style="border: 0"></iframe>'

    def __repr__(self) -> str:
        return f"View({self.url!r})"
