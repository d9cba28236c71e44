"""Readings by the names of their sensors."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

from ._native import Reading


class Readings(dict[str, Reading]):
    """The last readings of a robot. A name that is not there says which are."""

    def __init__(self, readings: Mapping[str, Reading] | None = None, sensors: Sequence[str] = ()) -> None:
        super().__init__(readings or {})
        self._sensors = list(sensors)

    def __missing__(self, name: object) -> Reading:
        if name in self._sensors:
            raise KeyError(f"{name} has not measured yet: run the world for its interval first")
        near = difflib.get_close_matches(str(name), self._sensors, 1)
        meant = f" (did you mean `{near[0]}`?)" if near else ""
        expected = f"expected one of {', '.join(self._sensors)}" if self._sensors else "this robot has none"
        raise KeyError(f"unknown sensor `{name}`{meant}: {expected}")
