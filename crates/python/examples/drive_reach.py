#!/usr/bin/env python3
"""Drives a youBot of a server to a point with the policy of `ppo_reach.py`, over the Gamebots socket. Needs only NumPy.

    usarsim serve --map rough &
    python3 drive_reach.py reach.npz [--port 3000] [--goal 2.0 -1.5]

The policy learned with the state of the simulation every 0.04 s. Here it gets the ground truth that arrives every 0.1 s, and computes
velocities from it.
"""

import argparse
import re
import socket
import sys

import numpy as np

LIMITS = np.array([0.8, 0.8, 1.25])


def policy(path):
    """The network: two layers of 64 with tanh, and a linear one."""
    arrays = list(np.load(path).values())

    def act(seen):
        for weights, bias in zip(arrays[:-2:2], arrays[1:-2:2]):
            seen = np.tanh(weights @ seen + bias)
        return np.clip(arrays[-2] @ seen + arrays[-1], -1, 1)

    return act


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("policy")
    arguments.add_argument("--port", type=int, default=3000)
    arguments.add_argument("--goal", type=float, nargs=2, default=[2.0, -1.5])
    arguments = arguments.parse_args()
    act, goal = policy(arguments.policy), np.array(arguments.goal)
    truth = re.compile(r"\{Time ([-\d.]+)\}.*\{Type GroundTruth\}.*\{Location ([-\d.,]+)\} \{Orientation ([-\d.,]+)\}")
    before = None
    with socket.create_connection(("127.0.0.1", arguments.port)) as server:
        server.sendall(b"INIT {ClassName USARBot.YouBot} {Location 0,0,0} {Rotation 0,0,0}\r\n")
        for line in server.makefile(encoding="utf-8"):
            found = truth.search(line)
            if not found:
                continue
            time = float(found[1])
            place, angles = ([float(number) for number in found[group].split(",")] for group in (2, 3))
            now = np.array([time, place[0], place[1], angles[2]])
            far = np.hypot(*(goal - now[1:3]))
            print(f"{time:6.2f} s  {far:.3f} m to go")
            if far < 0.1:
                server.sendall(b"DRIVE {LinearVelocity 0} {LateralVelocity 0} {RotationalVelocity 0}\r\n")
                return 0
            if time > 30:
                return 1
            past, before = before, now
            if past is None:
                continue
            step = now - past
            step[3] = (step[3] + np.pi) % (2 * np.pi) - np.pi
            turn = np.array([[np.cos(now[3]), np.sin(now[3])], [-np.sin(now[3]), np.cos(now[3])]])
            seen = [*(turn @ (goal - now[1:3])), *(turn @ step[1:3] / step[0]), step[3] / step[0]]
            forward, right, clockwise = LIMITS * act(np.array(seen))
            order = f"DRIVE {{LinearVelocity {forward:.4f}}} {{LateralVelocity {right:.4f}}} {{RotationalVelocity {clockwise:.4f}}}\r\n"
            server.sendall(order.encode())
    return 1


if __name__ == "__main__":
    sys.exit(main())
