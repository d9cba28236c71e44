#!/usr/bin/env python3
"""Drives a robot on a server for a moment, and reads its page.

Usage: drive.py PORT PORT_OF_THE_PAGE
"""

import re
import socket
import sys
import time
import urllib.request


def main():
    port, page = map(int, sys.argv[1:])
    client = socket.create_connection(("127.0.0.1", port), timeout=30)
    client.sendall(b"INIT {ClassName USARBot.P3AT} {Name R1} {Start PlayerStart_0}\r\nDRIVE {Left 3} {Right 3}\r\n")
    end, gone = time.monotonic() + 60, 0.0
    for line in client.makefile(encoding="utf-8"):
        place = re.search(r"{Type GroundTruth}.*{Location (-?[\d.]+),(-?[\d.]+),", line)
        gone = max(gone, abs(float(place[1]))) if place else gone
        if gone > 0.2:
            break
        assert time.monotonic() < end, f"it has moved {gone} m in a minute: expected 0.2"
    html = urllib.request.urlopen(f"http://127.0.0.1:{page}/", timeout=30).read().decode()
    script = re.search(r'src="\.?/?(assets/[^"]+\.js)"', html)
    assert script, f"no page in the program, but: {html[:300]}"
    assert len(urllib.request.urlopen(f"http://127.0.0.1:{page}/{script[1]}", timeout=30).read()) > 100_000


main()
