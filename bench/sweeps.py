#!/usr/bin/env python3
"""A sweep of 500 runs here, by two processes of Dask, and by two of which one is killed: times, and whether the tables have the same bytes.

    pip install ./crates/python[dask]
    python3 bench/sweeps.py [--runs 500] [--seconds 60]

Every run is a P3AT that turns on the spot for the given simulated seconds, with another mass and start. Batches have ten runs.
"""

import argparse
import concurrent.futures
import os
import resource
import signal
import tempfile
from pathlib import Path

import distributed
from usarsim.sweep import run_sweep

PLAN = """
description = "P3ATs of several weights turn on the spot"
samples = {samples}
[setup]
map = "rough"
robot = "P3AT"
drive = "{{Left 2}} {{Right -2}}"
steps = 2
step_seconds = {seconds}
[tolerances]
position = 0.1
mass = 0.2
[[axis]]
name = "friction"
set = ["material.carpet.friction={{}}"]
range = [0.3, 0.75, 0.05]
"""
BATCH = 10


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=500)
    arguments.add_argument("--seconds", type=float, default=60)
    arguments = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        plan = folder / "plan.toml"
        plan.write_text(PLAN.format(samples=arguments.runs // 10, seconds=arguments.seconds / 2))
        with concurrent.futures.ProcessPoolExecutor(2) as executor:
            alone = run_sweep(plan, folder / "alone", executor, batch_size=BATCH)
        table = alone.table.read_bytes()
        print(f"two processes of Python: {alone.runs} runs in {alone.seconds:.1f} s, {1e3 * 2 * alone.seconds / alone.runs:.0f} ms a run and core")
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            with distributed.Client(cluster) as client:
                spread = run_sweep(plan, folder / "spread", client, batch_size=BATCH)
                more = 100 * (spread.seconds / alone.seconds - 1)
                same = "the same" if spread.table.read_bytes() == table else "OTHER"
                print(f"two processes of Dask: {spread.seconds:.1f} s, {more:+.1f} %, {same} bytes")
                victim, killed = next(iter(client.run(os.getpid).values())), []

                def kill(progress):
                    if progress.done >= progress.batches // 3 and not killed:
                        os.kill(victim, signal.SIGKILL)
                        killed.append(progress.done)

                lost = run_sweep(plan, folder / "lost", client, batch_size=BATCH, progress=kill)
                same = "the same" if lost.table.read_bytes() == table else "OTHER"
                more = 100 * (lost.seconds / alone.seconds - 1)
                print(f"one of them killed after {killed[0]} batches: {lost.seconds:.1f} s, {more:+.1f} %, {same} bytes")
        parts = sum(part.stat().st_size for part in (folder / "alone" / "parts").iterdir())
        print(f"parts: {parts / alone.runs:.0f} bytes a run, table: {len(table) / alone.runs:.0f} bytes a run")
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(f"memory of this process: {memory / 1e3:.0f} MB")


if __name__ == "__main__":
    main()
