"""`usarsim connect` and `usarsim teleop` at a real terminal: a pseudo-terminal, with keys typed as a person does.

Usage: terminal.py PROGRAM
"""

import json
import os
import pty
import re
import select
import socket
import subprocess
import sys
import tempfile
import time

PROGRAM = sys.argv[1]
PATIENCE = 30


class Terminal:
    """A program at a terminal of its own."""

    def __init__(self, *arguments):
        self.shown, self.home = "", tempfile.mkdtemp()
        environment = os.environ | {"HOME": self.home, "TERM": "xterm", "NO_COLOR": "1"}
        environment.pop("XDG_STATE_HOME", None)
        self.process, self.terminal = pty.fork()
        if self.process == 0:
            os.execve(PROGRAM, [PROGRAM, *arguments], environment)

    def type(self, text):
        os.write(self.terminal, text.encode())

    def wait_for(self, pattern):
        """Reads until the pattern has been shown; what was shown before it is forgotten."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            match = re.search(pattern, self.shown)
            if match:
                self.shown = self.shown[match.end() :]
                return match
            if select.select([self.terminal], [], [], 0.1)[0]:
                try:
                    self.shown += os.read(self.terminal, 65536).decode(errors="replace")
                except OSError:
                    break
        raise AssertionError(f"never shown: {pattern}; last: {self.shown[-400:]!r}")

    def end(self):
        """The exit code."""
        return os.waitstatus_to_exitcode(os.waitpid(self.process, 0)[1])


def check_connect(address):
    terminal = Terminal("connect", address)
    terminal.wait_for("NFO {Gametype BotDeathMatch}")
    # What is typed while there is no prompt is lost, as with every line editor.
    next_prompt = r"2004l\r\n[\s\S]*?> \r[\s\S]*?2026l"
    # The server's answers come without being shown.
    time.sleep(0.5)
    terminal.type("help\r")
    terminal.wait_for("classes: USARBot.ARDrone, [^\n]*\n[^\n]*starts: PlayerStart_0, [\\s\\S]*> \r")
    terminal.type("INI\t{Cl\tUSARBot.P3TA}\r")
    terminal.wait_for("NFO {Error 'ClassName USARBot.P3TA' is unknown .did you mean `USARBot.P3AT`")
    terminal.type("INI\t{Cl\tp3a\t{St\tRobotStart1}\r")
    terminal.wait_for(next_prompt)
    terminal.type("GETCONF {Type Robot}\r")
    terminal.wait_for("CONF {Name P3AT}")
    terminal.type(":watch GroundTruth\r")
    terminal.wait_for("SEN {Time [0-9.]+} {Type GroundTruth}")
    terminal.type(":unwatch\r")
    terminal.wait_for(next_prompt)
    terminal.type(":quit\r")
    assert terminal.end() == 0
    with open(os.path.join(terminal.home, ".local/state/usarsim/history")) as history:
        assert "INIT {ClassName USARBot.P3AT} {Start RobotStart1}" in history.read()


def check_teleop(address):
    terminal = Terminal("teleop", address, "--start", "RobotStart2")
    terminal.wait_for("keys: w s forward, backward   a d left, right   q e turn ")
    x_and_y = r"x (-?[0-9.]+)  y (-?[0-9.]+)  z"
    start = terminal.wait_for(x_and_y)
    # RobotStart2 of `rough` looks to the right.
    for key, axis, sign in [("w", 2, 1), ("d", 1, -1), ("\x1b[A", 2, 1)]:
        before = float(terminal.wait_for(x_and_y)[axis])
        end = time.monotonic() + PATIENCE
        while sign * (float(terminal.wait_for(x_and_y)[axis]) - before) < 0.03:
            assert time.monotonic() < end, f"{key!r} does not move it"
            terminal.type(key)
    assert start
    terminal.type("+")
    terminal.wait_for(" 50 %")
    terminal.type("x")
    assert terminal.end() == 0


def check_pipe(address):
    done = subprocess.run([PROGRAM, "connect", address], input="GETSTARTPOSES\n", capture_output=True, text=True)
    assert done.returncode == 0 and "NFO {StartPoses 3}" in done.stdout, done
    refused = subprocess.run([PROGRAM, "connect", "127.0.0.1:1"], input="", capture_output=True, text=True)
    assert refused.returncode == 69 and "usarsim serve" in refused.stderr, refused
    for arguments, code, expected in [
        (["--robot", "KUKAYouBot"], 1, "KUKAYouBot was not spawned: 'ClassName USARBot.KUKAYouBot' is unknown (did you mean `USARBot.KUKA_"),
        (["--start", "RobotStart"], 0, "WARNING 'Start RobotStart' is unknown (did you mean `RobotStart1`?)"),
    ]:
        done = subprocess.run([PROGRAM, "teleop", address, *arguments], input="", capture_output=True, text=True)
        assert done.returncode == code and expected in done.stdout + done.stderr, done


def main():
    command = [PROGRAM, "--quiet", "serve", "--map", "rough", "--json", "--port", "0", "--no-http"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        address = f"127.0.0.1:{json.loads(server.stdout.readline())['port']}"
        socket.create_connection(address.rsplit(":", 1)).close()
        check_connect(address)
        check_teleop(address)
        check_pipe(address)
        print("terminal: connect and teleop work at a terminal and in a pipe")
    finally:
        server.terminate()
        server.wait()


main()
