#!/usr/bin/env python3
"""Model-predictive control of a youBot: a planner copies the world for each of its tries.

    pip install ./crates/python
    python3 mpc.py [--seconds 12] [--seed 1] [--picture mpc.png]

The robot parks at a pose on a slippery floor. Every 0.2 s, 128 copies of the world try random velocities for 2 s (the cross-entropy
method, three rounds), and the robot drives the first velocity of the best. The planner has the floor, friction and rollers of the real
thing, because its model is the world itself.
"""

import argparse

import numpy as np
import usarsim

GOAL, HEADING = np.array([1.5, 1.0]), 1.57
LIMITS = np.array([0.8, 0.8, 1.0])
TRIES, ROUNDS, BEST, PIECES, STEPS = 128, 3, 16, 5, 20


def turn_to(yaw):
    """How far a heading is from the goal's, rad, -pi to pi."""
    return (yaw - HEADING + np.pi) % (2 * np.pi) - np.pi


def plan(world, mean, random):
    """Returns the best velocities for the next 2 s, in pieces of 0.4 s."""
    batch = usarsim.Batch(world, TRIES, orders="twist", observations=["position", "rotation"])
    spread = np.full((PIECES, 3), 0.5) * LIMITS
    for _ in range(ROUNDS):
        tries = np.clip(mean + spread * random.standard_normal((TRIES, PIECES, 3)), -LIMITS, LIMITS)
        tries[0] = mean
        seen, cost = batch.reset(), np.zeros(TRIES)
        for piece in range(PIECES):
            seen = batch.step(np.ascontiguousarray(tries[:, piece]), STEPS)
            cost += np.hypot(*(seen[:, :2] - GOAL).T) + 0.3 * np.abs(turn_to(seen[:, 5]))
        cost += 0.02 * np.square(tries).sum((1, 2))
        best = tries[np.argsort(cost)[:BEST]]
        mean, spread = best.mean(0), best.std(0) + 0.02
    return best[0]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--seconds", type=float, default=12)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--picture")
    arguments = arguments.parse_args()
    scene = usarsim.Scene("smooth", set=["material.cast-acrylic.friction=0.15"], drive_model="analytic")
    world = usarsim.World(scene, time_step=0.02, seed=arguments.seed)
    robot = world.spawn("YouBot", position=(0.0, 0.0, 0.0))
    random, mean = np.random.default_rng(arguments.seed), np.zeros((PIECES, 3))
    while world.time < arguments.seconds:
        best = plan(world, mean, random)
        robot.drive_twist(*best[0])
        world.run(0.2)
        # The plan goes on from here: half a piece is done.
        mean = 0.5 * (best + np.concatenate([best[1:], best[-1:]]))
        far, turn = np.hypot(*(robot.position[:2] - GOAL)), turn_to(robot.rotation[2])
        print(f"{world.time:5.1f} s  {far:.3f} m and {turn:6.3f} rad to go")
        is_there = far < 0.05 and abs(turn) < 0.05
        if is_there:
            break
    if arguments.picture:
        world.picture((960, 540)).save(arguments.picture)
    return 0 if is_there else 1


if __name__ == "__main__":
    raise SystemExit(main())
