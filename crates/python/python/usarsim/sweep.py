"""Sweeps: an experiment of many runs, on this machine or spread over a cluster.

>>> from concurrent.futures import ThreadPoolExecutor
>>> from usarsim.sweep import run_sweep
>>> with ThreadPoolExecutor(2) as executor:  # doctest: +SKIP
...     run_sweep("plan.toml", "results", executor)

With Dask, the executor is a client:

>>> from dask.distributed import Client  # doctest: +SKIP
>>> run_sweep("plan.toml", "/shared/results", Client("scheduler:8786"))  # doctest: +SKIP

A task is a batch of runs. It writes one Parquet part into the folder, under a temporary name, and renames it. The folder has to be the same
for all machines. A part has the same bytes wherever it is made, and a lost worker costs the batches that it had under way: Dask gives them
to another one. A sweep that is interrupted goes on where it was.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _native

__all__ = ["Progress", "Sweep", "run_sweep"]

# Tasks that wait in the executor: enough that no worker waits, few enough that a million batches need no memory there.
_WAITING = 1000
# Times that Dask gives a batch to another worker after the first was lost.
_RETRIES = 5


@dataclass(frozen=True)
class Progress:
    """How far a sweep is."""

    batches: int
    """Batches in all."""
    done: int
    """Batches that are done, those of an earlier call included."""
    seconds: float
    """Time since this call began, s."""


@dataclass(frozen=True)
class Sweep:
    """Result of a sweep."""

    folder: Path
    """Folder of the results."""
    runs: int
    """Runs in all."""
    kept: int
    """Batches that an earlier call had done."""
    seconds: float
    """Time of this call, s."""

    @property
    def table(self) -> Path:
        """Table of all runs, a Parquet file."""
        return self.folder / "runs.parquet"

    @property
    def report(self) -> Path:
        """Report with tables and plots, a page."""
        return self.folder / "report.html"


def _run_batch(file: str, text: str, batch_size: int, out: str, batch: int) -> int:
    """Does one batch on a worker."""
    return _native._sweep_batch(file, text, batch_size, out, batch)


def _submitter(executor: Any) -> Callable[..., Future[int]]:
    """Returns the function that gives a task to an executor, or to a client of Dask."""
    if isinstance(executor, Executor):
        return executor.submit
    if hasattr(executor, "get_executor"):
        # A batch is pure only in its part: Dask must not take the result of another folder for it.
        return executor.get_executor(pure=False, retries=_RETRIES).submit  # type: ignore[no-any-return]
    raise TypeError(f"executor: got {type(executor).__name__}, expected a concurrent.futures.Executor or a Dask client")


def run_sweep(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str],
    executor: Any,
    *,
    batch_size: int = 100,
    progress: Callable[[Progress], None] | None = None,
) -> Sweep:
    """Runs an experiment file into the folder `out`, a batch of `batch_size` runs a task.

    `executor` is any `concurrent.futures.Executor`, or a client of Dask. `progress` is called after each batch. A batch that fails ends the
    sweep with its error; what is done is kept. Raises `usarsim.TaskError` if the experiment has a mistake, or the folder has other contents.
    """
    start = time.monotonic()
    file, out = os.path.abspath(file), os.path.abspath(out)
    text = Path(file).read_text(encoding="utf-8")
    submit = _submitter(executor)
    runs, batches, missing = _native._sweep_batches(file, text, batch_size, out)
    kept = batches - len(missing)
    done, waiting, left = kept, set[Future[int]](), iter(missing)
    try:
        while True:
            while len(waiting) < _WAITING and (batch := next(left, None)) is not None:
                waiting.add(submit(_run_batch, file, text, batch_size, out, batch))
            if not waiting:
                break
            finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
                done += 1
                if progress is not None:
                    progress(Progress(batches, done, time.monotonic() - start))
    finally:
        for future in waiting:
            future.cancel()
    _native._finish_sweep(file, text, batch_size, out)
    return Sweep(Path(out), runs, kept, time.monotonic() - start)
