#!/usr/bin/env python3
"""Learns to drive a youBot to a point by PPO, and saves the policy as plain arrays.

    pip install "./crates/python[gym]" stable-baselines3
    python3 ppo_reach.py [--seed 1] [--steps 300000] [--out reach.npz] [--plot reach.png]

`drive_reach.py` drives a robot of a server with the policy.
"""

import argparse
import time

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from usarsim.gym import TaskVectorEnv
from usarsim.sb3 import TaskVecEnv

TASK, WORLDS = "YouBotReach", 64


class Curve(BaseCallback):
    """Collects the part of successful episodes and the mean return of each rollout."""

    def __init__(self):
        super().__init__()
        self.rows, self.ended, self.start = [], [], time.monotonic()

    def _on_step(self):
        self.ended += [(info["is_success"], info["episode"]["r"]) for info in self.locals["infos"] if "episode" in info]
        return True

    def _on_rollout_end(self):
        if self.ended:
            success, returns = np.mean(self.ended, axis=0)
            self.rows.append((time.monotonic() - self.start, self.num_timesteps, success, returns))
            seconds, steps, success, returns = self.rows[-1]
            print(f"{seconds:6.0f} s  {steps:8d} steps  {100 * success:5.1f} % arrive  return {returns:6.2f}", flush=True)
            self.ended = []


def evaluate(policy, worlds=1000, seed=10_000):
    """Plays the mean action in worlds that the policy has not seen. Returns the part that arrives, and the mean time, s."""
    environments = TaskVectorEnv(TASK, worlds, autoreset_mode="Disabled")
    seen, _ = environments.reset(seed=seed)
    arrived, steps = np.zeros(worlds, bool), np.zeros(worlds)
    is_over = np.zeros(worlds, bool)
    while not is_over.all():
        seen, _, terminated, truncated, info = environments.step(policy(seen))
        arrived |= info["is_success"]
        steps += ~is_over
        is_over |= terminated | truncated
    return arrived.mean(), steps[arrived].mean() * environments.unwrapped._core.control_interval


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--steps", type=int, default=300_000)
    arguments.add_argument("--out", default="reach.npz")
    arguments.add_argument("--plot")
    arguments = arguments.parse_args()
    torch.set_num_threads(2)
    environments = TaskVecEnv(TASK, WORLDS)
    environments.seed(1000 * arguments.seed)
    model = PPO(
        "MlpPolicy", environments, seed=arguments.seed, n_steps=128, batch_size=1024, n_epochs=5, gamma=0.98,
        learning_rate=1e-3, ent_coef=0.0, device="cpu", policy_kwargs={"net_arch": [64, 64]},
    )
    curve = Curve()
    model.learn(arguments.steps, callback=curve)
    arrived, seconds = evaluate(lambda seen: np.clip(model.predict(seen, deterministic=True)[0], -1, 1))
    print(f"seed {arguments.seed}: {100 * arrived:.1f} % of 1000 new worlds arrive, after {seconds:.2f} s in the mean")
    layers = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
    arrays = [array.detach().numpy() for layer in layers for array in layer.parameters()]
    np.savez(arguments.out, *arrays)
    if arguments.plot:
        import matplotlib.pyplot as plot

        _, steps, success, returns = np.transpose(curve.rows)
        figure, axes = plot.subplots(figsize=(7, 3.5), layout="constrained")
        axes.plot(steps / 1e6, 100 * success, label="episodes that arrive, %")
        axes.plot(steps / 1e6, 20 * returns, label="mean return x 20")
        axes.set(xlabel="steps, millions", title=f"PPO on {TASK}, {WORLDS} worlds, seed {arguments.seed}")
        axes.legend(), axes.grid(alpha=0.3)
        figure.savefig(arguments.plot, dpi=120)


if __name__ == "__main__":
    main()
