#!/usr/bin/env python3
"""Many worlds at once from Python: usarsim's Batch beside mujoco.rollout, and the vector environment beside environments one by one.

    pip install ./crates/python[gym] mujoco
    python3 bench/learning.py [--seconds 5] [--threads 2] [--out docs/howto-learning.md]

Both simulators step the youBot base for 20 ms of control time in time steps of 4 ms, with random orders of -10 to 10 rad/s to its wheels,
on as many threads, in turns in one run. usarsim steps 1024 worlds of the model `analytic`. MuJoCo gets the robot that
`usarsim show robot KUKA_YouBot` prints, with its 24 rollers as bodies on hinges: ellipsoids, which it does fastest, and chains of nine
spheres, which are the shape of the rollers. The state of every robot comes back to NumPy in both.

The fastest of the repeats counts, as these machines are noisy. `--out` replaces the tables of a page between its marks.
"""

import argparse
import re
import time

import compare
import gymnasium
import mujoco
import numpy as np
import usarsim
import usarsim.gym
from mujoco import rollout

WORLDS, STEPS, STEP = 1024, 5, 0.004


def usarsim_steps(threads, seconds):
    """Robot-steps a second of a batch of youBots."""
    scene = usarsim.Scene("rough", drive_model="analytic")
    world = usarsim.World(scene, time_step=STEP)
    world.spawn("KUKA_YouBot", position=(0, 0, 0))
    batch = usarsim.Batch(world, WORLDS, orders="wheels", threads=threads)
    random, best = np.random.default_rng(0), 0.0
    orders = random.uniform(-10, 10, (50, WORLDS, 4))
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        start, count = time.perf_counter(), 0
        for row in orders[:10]:
            batch.step(row, STEPS)
            count += WORLDS * STEPS
        best = max(best, count / (time.perf_counter() - start))
        random.shuffle(orders)
    return best


def mujoco_steps(shape, cone, threads, seconds):
    """Robot-steps a second of mujoco.rollout with the same robot."""
    model = compare.model(compare.robot("KUKA_YouBot"), shape, cone, STEP)
    datas = [mujoco.MjData(model) for _ in range(threads)]
    mujoco.mj_step(model, datas[0], 250)
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, spec))
    mujoco.mj_getState(model, datas[0], state, spec)
    rows, controls = 256, 10
    initial, random, best = np.tile(state, (rows, 1)), np.random.default_rng(0), 0.0
    with rollout.Rollout(nthread=threads) as run:
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            control = np.repeat(random.uniform(-10, 10, (rows, controls, 4)), STEPS, axis=1)
            start = time.perf_counter()
            run.rollout(model, datas, initial, control)
            best = max(best, rows * controls * STEPS / (time.perf_counter() - start))
    return best


def vector_steps(task, count, threads, seconds):
    """Environment steps a second of the native vector."""
    environments = gymnasium.make_vec(f"usarsim/{task}-v0", num_envs=count, threads=threads)
    environments.reset(seed=0)
    actions, best = environments.action_space.sample(), 0.0
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        for _ in range(20):
            environments.step(actions)
        best = max(best, 20 * count / (time.perf_counter() - start))
    return best


def single_steps(task, count, seconds):
    """Environment steps a second of as many environments one by one, as `gymnasium.make` gives them."""
    environments = [gymnasium.make(f"usarsim/{task}-v0") for _ in range(count)]
    for number, environment in enumerate(environments):
        environment.reset(seed=number)
    action, best = environments[0].action_space.sample(), 0.0
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        for environment in environments:
            _, _, terminated, truncated, _ = environment.step(action)
            if terminated or truncated:
                environment.reset()
        best = max(best, count / (time.perf_counter() - start))
    return best


def table(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(row) + " |" for row in rows)])


def replaced(page, name, text):
    """The page with a table between its marks."""
    pattern = rf"(<!-- learning: {name} -->\n\n).*?(\n\n<!-- end -->)"
    page, count = re.subn(pattern, lambda match: match[1] + text + match[2], page, flags=re.DOTALL)
    if count != 1:
        raise SystemExit(f"expected one table {name}, got {count}")
    return page


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--seconds", type=float, default=5)
    arguments.add_argument("--threads", type=int, default=2)
    arguments.add_argument("--out")
    arguments = arguments.parse_args()
    seconds, threads = arguments.seconds, arguments.threads
    ours = usarsim_steps(threads, seconds)
    peers = {}
    for shape, cone in (("ellipsoid", "pyramidal"), ("ellipsoid", "elliptic"), ("chain 9", "elliptic")):
        peers[shape, cone] = mujoco_steps(shape, cone, threads, seconds)
        ours = max(ours, usarsim_steps(threads, seconds))
    rows = [["usarsim, `analytic`", f"{ours:,.0f}".replace(",", " "), "1"]]
    for (shape, cone), steps in peers.items():
        rows.append([f"MuJoCo {mujoco.__version__}, {shape}, {cone} cone", f"{steps:,.0f}".replace(",", " "), f"1/{ours / steps:.1f}"])
    first = table(["simulator and rollers", "robot-steps of 4 ms a second", "of usarsim"], rows)
    rows = []
    for task in ("YouBotReach", "YouBotPush", "P3ATExplore"):
        single, vector = single_steps(task, 64, seconds), vector_steps(task, 1024, threads, seconds)
        rows.append([f"`{task}`", f"{single:,.0f}".replace(",", " "), f"{vector:,.0f}".replace(",", " "), f"{vector / single:.1f}"])
    second = table(["task", "one by one, steps a second", "1024 in a vector", "times"], rows)
    print(first, second, sep="\n\n")
    if arguments.out:
        with open(arguments.out, encoding="utf-8") as file:
            page = file.read()
        page = replaced(replaced(page, "batch", first), "vector", second)
        with open(arguments.out, "w", encoding="utf-8") as file:
            file.write(page)


if __name__ == "__main__":
    main()
