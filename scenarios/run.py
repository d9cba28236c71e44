#!/usr/bin/env python3
"""Finishes scenarios over the wire: starts a server for each, runs the scenario's solve.py as a controller, and asks the server whether all goals
are reached.

    python3 scenarios/run.py                      # all of them
    python3 scenarios/run.py stairs cube --rtf 1  # some, in real time: watch them in the page
    python3 scenarios/run.py stairs --demo        # and write scenarios/stairs/demo.txt from the run

USARSIM names the program; otherwise it is target/release/usarsim.
"""

import argparse
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.request

HERE = pathlib.Path(__file__).parent
PROGRAM = os.environ.get("USARSIM") or HERE.parent / "target/release/usarsim"
# Real time for the server's answer after the last line of a controller, s.
PATIENCE = 20


def solve_of(name):
    sys.path.insert(0, str(HERE))
    sys.dont_write_bytecode = True
    spec = importlib.util.spec_from_file_location(f"solve_{name}", HERE / name / "solve.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.solve


def finished(http):
    """The simulated time in which all goals were reached, s, or None."""
    with urllib.request.urlopen(f"http://127.0.0.1:{http}/league.json") as answer:
        return json.load(answer)["teams"][0].get("finished")


def run(name, rtf, log):
    command = [PROGRAM, "--quiet", "serve", "--scenario", HERE / name, "--port", "0", "--http", "0", "--rtf", str(rtf), "--json"]
    command += ["--log", log] if log else []
    server = subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, text=True)
    try:
        ports = json.loads(server.stdout.readline())
        if rtf == 1:
            print(f"{name}: see it at http://127.0.0.1:{ports['http']}", flush=True)
        # What it returns keeps its robots in the world.
        robots = solve_of(name)(ports["port"])
        end = time.time() + PATIENCE
        while (took := finished(ports["http"])) is None and time.time() < end:
            time.sleep(0.1)
        del robots
        return took
    finally:
        server.terminate()
        server.wait(10)


def write_demo(name, log):
    """Writes the lines of a run with their times."""
    command = [str(PROGRAM), "log", "cat", log, "--json"]
    lines = map(json.loads, subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines())
    text = "".join(f"{line['time']:.4f} {line['connection']} {line['line']}\n" for line in lines if line["direction"] == "in")
    (HERE / name / "demo.txt").write_text(f"# Lines of a run of solve.py: time in s, client, line. Made by ../run.py --demo.\n{text}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("names", nargs="*", default=sorted(path.parent.name for path in HERE.glob("*/scenario.toml")))
    arguments.add_argument("--rtf", type=float, default=4)
    arguments.add_argument("--demo", action="store_true")
    arguments = arguments.parse_args()
    failed = []
    for name in arguments.names:
        began = time.time()
        with tempfile.TemporaryDirectory() as folder:
            log = f"{folder}/run.mcap" if arguments.demo else None
            took = run(name, arguments.rtf, log)
            if arguments.demo and took is not None:
                write_demo(name, log)
        result = "not finished" if took is None else f"finished in {took:.1f} s"
        print(f"{name:<10} {result} ({time.time() - began:.0f} s)", flush=True)
        failed += [name] if took is None else []
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
