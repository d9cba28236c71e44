"""Sweeps on executors of Python and on Dask."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest
import usarsim
from usarsim.sweep import run_sweep

PLAN = """
description = "P3ATs of several weights turn on the spot"
samples = {samples}
drive_models = ["articulated"]
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
numbers = [0.5, 0.8]
"""


@pytest.fixture
def plan(tmp_path):
    """An experiment of 20 short runs."""
    return write(tmp_path, 10, 0.2)


def write(folder, samples, seconds):
    path = folder / "plan.toml"
    path.write_text(PLAN.format(samples=samples, seconds=seconds))
    return path


def files(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*") if path.is_file()}


def test_the_table_is_the_same_on_every_executor(plan, tmp_path):
    seen = []
    with ThreadPoolExecutor(2) as executor:
        threads = run_sweep(plan, tmp_path / "threads", executor, batch_size=3, progress=seen.append)
    assert threads.runs == 20 and threads.kept == 0
    assert [it.done for it in seen] == list(range(1, 8)) and seen[-1].batches == 7
    with ProcessPoolExecutor(2) as executor:
        processes = run_sweep(plan, tmp_path / "processes", executor, batch_size=3)
    assert threads.table.read_bytes() == processes.table.read_bytes()
    command = [sys.executable, "-m", "usarsim", "sweep", str(plan), "--out", str(tmp_path / "program"), "--batch", "3"]
    assert subprocess.run(command, capture_output=True).returncode == 0
    assert files(tmp_path / "threads") == files(tmp_path / "processes") == files(tmp_path / "program")
    assert "report.html" in files(tmp_path / "program")


def test_a_sweep_goes_on_where_it_was(plan, tmp_path):
    with ThreadPoolExecutor(1) as executor:
        whole = run_sweep(plan, tmp_path / "out", executor, batch_size=4)
        table = whole.table.read_bytes()
        (tmp_path / "out" / "parts" / "000002.parquet").unlink()
        (tmp_path / "out" / "parts" / ".unfinished-x").write_text("of a lost worker")
        again = run_sweep(plan, tmp_path / "out", executor, batch_size=4)
        assert again.kept == 4 and again.table.read_bytes() == table
        assert not (tmp_path / "out" / "parts" / ".unfinished-x").exists()
        (tmp_path / "out" / "parts" / "000001.parquet").write_bytes(b"damaged")
        with pytest.raises(usarsim.TaskError, match="000001.parquet"):
            run_sweep(plan, tmp_path / "out", executor, batch_size=4)
        with pytest.raises(usarsim.TaskError, match="another sweep, or batches of another size"):
            run_sweep(plan, tmp_path / "out", executor, batch_size=5)
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine" / "thesis.txt").write_text("precious")
        with pytest.raises(usarsim.TaskError, match="expected an empty folder"):
            run_sweep(plan, tmp_path / "mine", executor)
        for size in (0, 10**9):
            with pytest.raises(usarsim.TaskError, match="expected 1 to"):
                run_sweep(plan, tmp_path / "other", executor, batch_size=size)
    with pytest.raises(TypeError, match="expected a concurrent.futures.Executor"):
        run_sweep(plan, tmp_path / "other", "executor")


def test_a_run_that_fails_ends_the_sweep_and_keeps_the_rest(tmp_path):
    path = write(tmp_path, 2, 0.2)
    path.write_text(path.read_text().replace('numbers = [0.5, 0.8]', 'numbers = [0.5, -1.0]'))
    with ThreadPoolExecutor(1) as executor, pytest.raises(usarsim.TaskError, match="friction"):
        run_sweep(path, tmp_path / "out", executor, batch_size=1)
    assert len(list((tmp_path / "out" / "parts").glob("*.parquet"))) == 2


def test_a_worker_of_dask_that_is_killed_costs_its_batch(tmp_path):
    distributed = pytest.importorskip("distributed")
    plan = write(tmp_path, 50, 2.0)
    with ThreadPoolExecutor(2) as executor:
        alone = run_sweep(plan, tmp_path / "alone", executor, batch_size=5)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            victim = next(iter(client.run(os.getpid).values()))
            killed = []

            def kill(progress):
                if progress.done >= 3 and not killed:
                    os.kill(victim, signal.SIGKILL)
                    killed.append(time.monotonic())

            spread = run_sweep(plan, tmp_path / "spread", client, batch_size=5, progress=kill)
    assert killed and spread.runs == alone.runs == 100
    assert spread.table.read_bytes() == alone.table.read_bytes()
