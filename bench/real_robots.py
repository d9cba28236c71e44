#!/usr/bin/env python3
"""Real skid-steered robots, usarsim, MuJoCo and PyBullet: how far each turns for what its wheels turn.

    python3 -m venv venv && venv/bin/pip install mujoco pybullet
    cargo build --release --bin usarsim      # or USARSIM names another build of the program
    venv/bin/python bench/real_robots.py [--out table.md]

The robots are the files of experiments/real that have turns: mass, wheelbase, track, radius, width, floor. Every simulator gets four
wheels with equal loads and servos that keep their speeds, steps of 2 ms, and 6 s of driving after 3 s. A number is the effective over the
geometric track: the difference of the wheels' speeds over track and yaw rate.

* MuJoCo as shipped: wheels as cylinders, the integrator implicitfast, as a stiff servo is unstable with the default one.
* MuJoCo at its best: elliptic friction cones, impratio 10, wheels as spheres, and rotors ten times as heavy at the rim as a quarter of the
  robot. Its contacts do not feel servos, and only a wheel that is hard to turn slides as a driven one does. Such a robot hardly sets out.
* PyBullet as shipped: wheels as cylinders, a motor with a large force.
* PyBullet at its best: friction cones, wheels as spheres, 50 more solver iterations.

Units: m, s, rad, kg; x forward, y left, z up.
"""

import argparse
import json
import math
import os
import subprocess
import tomllib
from pathlib import Path

import mujoco
import pybullet

ROOT = Path(__file__).resolve().parent.parent
USARSIM = os.environ.get("USARSIM") or str(ROOT / "target" / "release" / "usarsim")
STEP = 0.002
BEFORE, DURING = 3.0, 6.0
# Speed of the faster side's rims, m/s, and share of the mass in a wheel, as in crates/experiments/src/real.
SPEED, WHEEL_SHARE = 0.4, 0.02


class Robot:
    """Dimensions of a file, and the wheels' places: left, right, left, right."""

    def __init__(self, measured):
        for key in ("mass", "wheelbase", "track", "radius", "width"):
            setattr(self, key, measured["robot"][key])
        self.friction = measured["floor"]["friction"]
        self.places = [(way * self.wheelbase / 2, side * self.track / 2) for way in (1, -1) for side in (1, -1)]
        self.wheel_mass = WHEEL_SHARE * self.mass
        self.body_mass = self.mass - 4 * self.wheel_mass
        size = (max(self.wheelbase, self.track), self.track - self.width, self.radius)
        self.size = size
        self.inertia = [self.body_mass * (size[(n + 1) % 3] ** 2 + size[(n + 2) % 3] ** 2) / 12 for n in range(3)]

    def speeds(self, curvature):
        """Wheel speeds of a turn to the right, rad/s."""
        fast = SPEED / self.radius
        slow = fast * (curvature - 1) / (curvature + 1)
        return [fast, slow, fast, slow]


def in_mujoco(robot, curvature, best):
    gain = robot.mass * robot.radius**2 * 100
    rotor = 10 * robot.mass / 4 * robot.radius**2 if best else 0
    shape = f'type="sphere" size="{robot.radius}"' if best else f'type="cylinder" size="{robot.radius} {robot.width / 2}" euler="90 0 0"'
    wheels = "".join(
        f'<body pos="{x} {y} 0"><joint name="w{n}" axis="0 1 0" armature="{rotor}"/>'
        f'<geom {shape} mass="{robot.wheel_mass}" friction="{robot.friction} 0 0" condim="3"/></body>'
        for n, (x, y) in enumerate(robot.places)
    )
    servos = "".join(f'<velocity joint="w{n}" kv="{gain}"/>' for n in range(4))
    options = 'cone="elliptic" impratio="10"' if best else ""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="degree"/><option timestep="{STEP}" integrator="implicitfast" {options}/><worldbody>'
        f'<geom type="plane" size="50 50 1" friction="{robot.friction} 0 0" condim="3"/>'
        f'<body pos="0 0 {robot.radius}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{robot.body_mass}" diaginertia="{" ".join(map(str, robot.inertia))}"/>{wheels}</body>'
        f"</worldbody><actuator>{servos}</actuator></mujoco>"
    )
    data = mujoco.MjData(model)
    data.ctrl[:] = robot.speeds(curvature)

    def look():
        w, x, y, z = data.qpos[3:7]
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), data.qpos[7] - data.qpos[8]

    return measured_chi(robot, lambda: mujoco.mj_step(model, data), look)


def in_pybullet(robot, curvature, best):
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81)
    more = {"enableConeFriction": 1, "numSolverIterations": 100} if best else {}
    pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP, **more)
    plane = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    if best:
        wheel = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=robot.radius)
    else:
        wheel = pybullet.createCollisionShape(pybullet.GEOM_CYLINDER, radius=robot.radius, height=robot.width)
    body = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[length * 0.45 for length in robot.size])
    # A cylinder's axis is z, so a wheel's frame is turned about x.
    lying = pybullet.getQuaternionFromEuler([-math.pi / 2, 0, 0])
    car = pybullet.createMultiBody(
        robot.body_mass, body, basePosition=[0, 0, robot.radius], linkMasses=[robot.wheel_mass] * 4,
        linkCollisionShapeIndices=[wheel] * 4, linkVisualShapeIndices=[-1] * 4, linkPositions=[[x, y, 0] for x, y in robot.places],
        linkOrientations=[lying] * 4, linkInertialFramePositions=[[0, 0, 0]] * 4, linkInertialFrameOrientations=[[0, 0, 0, 1]] * 4,
        linkParentIndices=[0] * 4, linkJointTypes=[pybullet.JOINT_REVOLUTE] * 4, linkJointAxis=[[0, 0, 1]] * 4,
    )
    for number in range(4):
        # Bullet multiplies the two coefficients of a pair.
        pybullet.changeDynamics(car, number, lateralFriction=robot.friction, linearDamping=0, angularDamping=0)
        pybullet.setCollisionFilterPair(car, car, -1, number, 0)
    pybullet.changeDynamics(plane, -1, lateralFriction=1)
    pybullet.changeDynamics(car, -1, linearDamping=0, angularDamping=0)
    for number, speed in enumerate(robot.speeds(curvature)):
        pybullet.setJointMotorControl2(car, number, pybullet.VELOCITY_CONTROL, targetVelocity=speed, force=10 * robot.mass * robot.radius)

    def look():
        _, turn = pybullet.getBasePositionAndOrientation(car)
        return pybullet.getEulerFromQuaternion(turn)[2], pybullet.getJointState(car, 0)[0] - pybullet.getJointState(car, 1)[0]

    chi = measured_chi(robot, pybullet.stepSimulation, look)
    pybullet.disconnect(client)
    return chi


def measured_chi(robot, step, look):
    """Effective over geometric track; infinite if the robot does not turn."""
    for _ in range(round(BEFORE / STEP)):
        step()
    heading, start = look()
    turned = 0.0
    for _ in range(round(DURING / STEP)):
        step()
        now, _ = look()
        turned -= math.remainder(now - heading, 2 * math.pi)
        heading = now
    way = (look()[1] - start) * robot.radius
    return way / (robot.track * turned) if turned > 1e-6 else math.inf


PEERS = {
    "MuJoCo as shipped": lambda robot, curvature: in_mujoco(robot, curvature, False),
    "MuJoCo at its best": lambda robot, curvature: in_mujoco(robot, curvature, True),
    "PyBullet as shipped": lambda robot, curvature: in_pybullet(robot, curvature, False),
    "PyBullet at its best": lambda robot, curvature: in_pybullet(robot, curvature, True),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", help="file of the table, instead of the standard output")
    arguments = parser.parse_args()
    shown = subprocess.run([USARSIM, "experiment", "real", "--json", "--quiet"], check=True, capture_output=True)
    head = ["robot", "curvature", "real", "usarsim", *PEERS]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    worst = {}
    for robot in json.loads(shown.stdout)["robots"]:
        measured = tomllib.loads((ROOT / "experiments" / "real" / f"{robot['id']}.toml").read_text())
        if not measured.get("turn") or measured["robot"]["wheelbase"] == 0:
            continue
        for row in robot["rows"]:
            curvature, real = row["curvature"], row["real"]
            found = {"usarsim": row["ours"]} | {name: peer(Robot(measured), curvature) for name, peer in PEERS.items()}
            for name, chi in found.items():
                worst[name] = max(worst.get(name, 0), abs(chi / real - 1))
            cells = [f"{chi:.3f} ({100 * (chi / real - 1):+.1f} %)" for chi in found.values()]
            lines.append(f"| {robot['name']} | {curvature:g} | {real:.3f} | " + " | ".join(cells) + " |")
    cells = [f"{100 * share:.1f} %" for share in worst.values()]
    lines.append("| worst | | | " + " | ".join(cells) + " |")
    table = "\n".join(lines) + "\n"
    if arguments.out:
        Path(arguments.out).write_text(table)
    else:
        print(table, end="")


if __name__ == "__main__":
    main()
