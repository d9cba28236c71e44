"""Prometheus' own parser reads /metrics, and a stranger does not.

Usage: metrics.py PROGRAM
"""

import json
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

PATIENCE = 30
TOKEN = "viewer-0123456789abcdef"


def scrape(url, token):
    request = urllib.request.Request(url)
    if token:
        request.add_header("Authorization", f"Bearer {token}")
    with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain; version=0.0.4"), answer.headers
        return {family.name: family for family in text_string_to_metric_families(answer.read().decode())}


def check(program, options, token):
    command = [program, "serve", "--port", "0", "--http", "0", "--rtf", "0", "--json", *options]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        ready = json.loads(server.stdout.readline())
        url = f"http://127.0.0.1:{ready['http']}/metrics"
        robot = socket.create_connection(("127.0.0.1", ready["port"]))
        robot.sendall(b"INIT {ClassName USARBot.P3AT}\r\n")
        end = time.monotonic() + PATIENCE
        while True:
            families = scrape(url, token)
            robots = families["usarsim_robots"].samples[0].value
            if families["usarsim_steps"].samples[0].value > 0 and (token or robots == 1):
                break
            assert time.monotonic() < end, "steps or the robot are never counted"
        for name, family in families.items():
            assert name.startswith("usarsim_") and family.documentation and family.type in ("gauge", "counter"), family
        assert families["usarsim_steps"].type == "counter", families["usarsim_steps"]
        # With tokens the robot has none, and neither has a stranger.
        assert not (token and robots), "a robot without a token"
        if token:
            try:
                scrape(url, None)
                raise AssertionError("a stranger reads /metrics")
            except urllib.error.HTTPError as error:
                assert error.code == 401, error
        return len(families)
    finally:
        server.terminate()
        server.wait(PATIENCE)


def main():
    program = sys.argv[1]
    count = check(program, [], None)
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(f'[[token]]\ntoken = "{TOKEN}"\nroles = ["viewer"]\n')
        file.flush()
        assert check(program, ["--token-file", file.name], TOKEN) == count
    print(f"metrics: {count} families, read by prometheus_client")


main()
