#!/usr/bin/env python3
"""Writes docs/validation.md: what `usarsim validate` and `usarsim bench` find, as tables and plots.

    python3 -m venv venv && venv/bin/pip install matplotlib
    cargo build --release --bin usarsim      # or USARSIM names another build of the program
    venv/bin/python bench/validation.py [--out docs | --check docs/validation.md [--but-bodies]]

With `--check` it only makes the tables, and fails if they are not those of the page.
"""

import argparse
import csv
import json
import math
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

ROOT = os.path.join(os.path.dirname(__file__), "..")
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--out", default=os.path.join(ROOT, "docs"), help="folder of the page")
parser.add_argument("--check", metavar="PAGE", help="compare the tables with those of a page, and draw nothing")
parser.add_argument("--but-bodies", action="store_true", help="with --check, leave out the column of the youBot's bodies, which takes five minutes")
ARGUMENTS = parser.parse_args()
OUT = ARGUMENTS.out
USARSIM = os.environ.get("USARSIM") or os.path.join(ROOT, "target", "release", "usarsim")
COLOURS = {"bodies": "#1f5fa8", "articulated": "#8a4fa8", "analytic": "#d1495b", "kinematic": "#6b9e3f"}
# The same file every time.
matplotlib.rcParams["svg.hashsalt"] = "usarsim"


def run(*arguments):
    """The report of `usarsim bench` or `validate`, of the thesis's youBot unless another robot is named."""
    if "--robot" not in arguments:
        arguments += ("--robot", "KUKA_YouBot")
    done = subprocess.run([USARSIM, *map(str, arguments), "--json"], capture_output=True, text=True)
    if not done.stdout:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def each(measure, values):
    """Measures all values, as many at once as there are cores; each measurement is a process of its own."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(measure, values))


def found(model, check, what, *arguments):
    """The measured number of one finding."""
    report = run("validate", "--drive-model", model, "--check", check, "--seconds", 5, *arguments)
    return next(row["measured"] for row in report["findings"] if row["what"].startswith(what))


def plot(name, x_label, y_label, lines, log=False, points=False):
    """One picture of lines `(label, model or None, xs, ys)`; without a model it is theory, dashed. Points have no lines."""
    figure, axes = plt.subplots(figsize=(6, 3.6))
    for label, model, xs, ys in lines:
        style = {"color": COLOURS[model], "marker": "o"} if model else {"color": "black", "linestyle": "--"}
        if points:
            style |= {"linestyle": "", "marker": "."}
        axes.plot(xs, ys, label=label, **style)
    if log:
        axes.set_xscale("log")
        axes.set_xticks(lines[0][2], [f"{x:g}" for x in lines[0][2]])
        axes.minorticks_off()
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(os.path.join(OUT, "plots", f"{name}.svg"), metadata={"Date": None})
    plt.close(figure)
    print(name, flush=True)
    return f"![{y_label} against {x_label}](plots/{name}.svg)\n"


def lateral_against_rollers():
    counts = [5, 6, 8, 10, 12, 16]
    theory = [math.sin(math.pi / n) / (math.pi / n) for n in counts]
    lines = [("sin(pi/N) / (pi/N)", None, counts, theory)]
    for model in ("bodies", "articulated", "analytic"):
        # Four turns of the wheels are whole rollers for every count.
        ratios = each(lambda n: run("bench", "--drive-model", model, "--seconds", 4 * math.pi, "--set", f"KUKA_YouBot.rollers.count={n}")["motions"]["right"]["ratio"], counts)
        lines.append((model, model, counts, [ratio * exact for ratio, exact in zip(ratios, theory)]))
    return plot("lateral-ratio", "rollers of a wheel", "travel to the right over R theta", lines)


def traction_against_friction():
    rollers = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2]
    pairs = [(value + 0.8) / 2 for value in rollers]
    lines = [("Coulomb", None, pairs, [1.0 for _ in pairs])]
    for model in ("bodies", "articulated", "analytic"):
        ratios = each(lambda value: found(model, 9, "most acceleration ahead", "--set", f"robot.roller_friction={value}"), rollers)
        lines.append((model, model, pairs, ratios))
    return plot("traction", "friction of roller and floor", "most acceleration over mu g sin(angle)", lines)


def slope_against_friction():
    rollers = [0.2, 0.6, 1.0]
    pairs = [(value + 0.8) / 2 for value in rollers]
    # At rest two rollers straddle the lowest point, at a phase of 30 degrees.
    sine = math.sin(math.atan(math.cos(math.pi / 6)))
    lines = [("Coulomb on rollers at 30 degrees", None, pairs, [math.degrees(math.atan(mu * sine)) for mu in pairs])]
    for model in ("bodies", "articulated", "analytic"):
        lines.append((model, model, pairs, each(lambda value: found(model, 7, "slides ahead", "--set", f"robot.roller_friction={value}"), rollers)))
    return plot("slope", "friction of roller and floor", "slides ahead from, degrees", lines)


def free_rolling_against_rotor():
    rotors = [0.0, 0.002, 0.005, 0.01]
    lines = [("m / (m + 4 J / R²)", None, rotors, [1.0 for _ in rotors])]
    for model in ("bodies", "articulated", "analytic"):
        lines.append((model, model, rotors, each(lambda value: found(model, 8, "rolls ahead", "--set", f"KUKA_YouBot.wheels.armature={value}"), rotors)))
    return plot("free-rolling", "rotor inertia at the wheel, kg m²", "acceleration down 4.5 degrees over the bound", lines)


def ripple_against_phase():
    lines = []
    for model in ("bodies", "articulated", "analytic", "kinematic"):
        with tempfile.NamedTemporaryFile("r", suffix=".csv") as trace:
            run("bench", "--drive-model", model, "--dt", 0.002, "--seconds", 6, "--trace", trace.name)
            # Every fifth step shows as much.
            rows = [row for row in csv.DictReader(trace) if row["motion"] == "forward"][::5]
        phases = [math.degrees(float(row["phase"])) for row in rows]
        lines.append((model, model, phases, [1e3 * float(row["height"]) for row in rows]))
    return plot("ripple-phase", "phase of the wheel in its spacing of rollers, degrees", "height of the body, mm", lines, points=True)


def energy_against_step():
    steps = [0.0005, 0.001, 0.002, 0.004]
    lines = []
    for model in ("bodies", "articulated", "analytic"):
        losses = each(lambda step: -found(model, 11, "energy", "--dt", step), steps)
        lines.append((model, model, [1e3 * step for step in steps], losses))
    return plot("energy", "time step, ms", "energy lost, of its motion a second", lines, log=True)


def errors_against_step():
    steps = [0.0005, 0.001, 0.002, 0.004, 0.008]
    pictures, lines, ripples = [], [], []
    for model in ("bodies", "articulated", "analytic", "kinematic"):
        reports = each(lambda step: run("bench", "--drive-model", model, "--dt", step, "--seconds", 5), steps)
        milliseconds = [1e3 * step for step in steps]
        lines.append((model, model, milliseconds, [report["worst_error_percent"] for report in reports]))
        ripple = [max(motion["ripple_mm"] for motion in report["motions"].values()) for report in reports]
        ripples.append((model, model, milliseconds, ripple))
    pictures.append(plot("convergence", "time step, ms", "worst error, %", lines, log=True))
    pictures.append(plot("ripple", "time step, ms", "ripple, mm", ripples, log=True))
    return "\n".join(pictures)


def tables(names=("bodies", "articulated", "analytic", "kinematic")):
    """The findings of the youBot, a column for each drive model."""
    reports = each(lambda name: run("validate", "--drive-model", name)["findings"], names)
    lines = [f"| check | found | {' | '.join(names)} | right |", "|---|---|---|---|---|---|"]
    for rows in zip(*reports):
        cells = [f"{row['measured']:.4f}" + ("" if row["passes"] else " **no**") for row in rows]
        first = rows[0]
        right = f"at most {first['most']:g}" if first["least"] is None else f"{first['least']:.4g} to {first['most']:.4g}"
        lines.append(f"| {first['check']} | {first['what']} | {' | '.join(cells)} | {right} |")
    return "\n".join(lines) + "\n"


def plain_tables():
    """The findings of robots on plain wheels; the engine's bodies for one of them."""
    columns = [(name, "articulated") for name in ("P3AT", "P2AT", "P2DX", "BasicSkidRobot", "CasterSkidRobot", "Kenaf", "FrontAckerman", "BasicAckermanRobot")]
    columns.append(("P3AT", "bodies"))
    findings = each(lambda column: run("validate", "--robot", column[0], "--drive-model", column[1])["findings"], columns)
    reports = [{(row["check"], row["what"]): row for row in rows} for rows in findings]
    lines = ["| check | found | " + " | ".join(name + ("" if model == "articulated" else f", `{model}`") for name, model in columns) + " | right |"]
    lines.append("|---|---|" + "---|" * (len(columns) + 1))
    # A P3AT has all of them.
    for (check, what), first in reports[0].items():
        rows = [report.get((check, what)) for report in reports]
        cells = ["-" if row is None else f"{row['measured']:.4f}" + ("" if row["passes"] else " **no**") for row in rows]
        right = f"at most {first['most']:g}" if first["least"] is None else f"{first['least']:.4g} to {first['most']:.4g}"
        lines.append(f"| {check} | {what} | {' | '.join(cells)} | {right} |")
    return "\n".join(lines) + "\n"


def cells(lines):
    """The cells of the rows of tables, without those that only draw a line."""
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("|") and "---" not in line]


def check(page):
    """Fails if the tables of a page are not those of the program."""
    with open(page) as file:
        shown = cells(file)
    made = cells(plain_tables().splitlines())
    if ARGUMENTS.but_bodies:
        made = [row[:-1] for row in cells(tables(("articulated", "analytic", "kinematic")).splitlines())] + made
        rows = next(number for number, row in enumerate(shown[1:], 1) if row[0] == "check")
        # In the first table the third column is that of bodies, and the last has the bounds of theirs.
        shown = [row[:2] + row[3:-1] if number < rows else row for number, row in enumerate(shown)]
    else:
        made = cells(tables().splitlines()) + made
    wrong = [f"{page} shows {' | '.join(old)}\nthe program gives {' | '.join(new)}" for old, new in zip(shown, made) if old != new]
    if wrong or len(shown) != len(made):
        raise SystemExit("\n".join(wrong) or f"{page} shows {len(shown)} rows: the program gives {len(made)}")


def main():
    if ARGUMENTS.check:
        return check(ARGUMENTS.check)
    os.makedirs(os.path.join(OUT, "plots"), exist_ok=True)
    page = f"""# Validation

The twelve checks of a Mecanum robot that `usarsim validate --robot KUKA_YouBot` makes, for the thesis's youBot at the default step of 2 ms. This
page is made by `bench/validation.py`; `cargo test --test all validation` runs the same checks with shorter drives.

{tables()}
**no** marks what is out of bounds. `right` is for `bodies`; `analytic` is held to 0.3 % in checks 1 to 3.

* `bodies`, check 9: of a contact that slides, the engine solves both tangents by their own masses and then cuts their length, so
  friction leans toward the direction across a roller, where it is light, and up to an eighth of Coulomb's limit is lost.
* `articulated`, check 9: every roller has to be spun up as it comes down on a wheel that spins. With rollers of 0.01 kg instead of the
  thesis's 0.1 kg it reaches 0.992, with 0.001 kg 0.998 (`usarsim validate --robot KUKA_YouBot --drive-model articulated --set robot.rollers.mass=0.01`).
* `kinematic` knows no forces but its own: checks 7 to 11 are not meant for it.
* Check 11 pushes against a smooth bar as high as the hubs. What it pushes back with takes load off the front wheels, which slide
  first: 11 % before four equal wheels would.
* The limits of checks 7, 9 and 11 are those of rollers at their phase: a roller at the phase phi carries force at the angle
  atan(cos phi) to the axle, so a youBot that stands on two rollers a wheel slides ahead from 29.1 degrees and aside from 32.7, not
  from 31 both ways.

## Robots on plain wheels

The nine checks of every other robot on wheels (`usarsim validate --robot P3AT`), in `articulated`, and of a P3AT in `bodies`: straight on, on the
spot and on a curve beside the balance of friction ([kinematics.md](kinematics.md)), hold on a slope, roll down it, traction, climb, energy,
determinism. A car does not turn on the spot; with casters the load of the driven wheels changes with the slope and with the
acceleration, and those checks are left out.

{plain_tables()}
## Ride height

{ripple_against_phase()}
## Energy

Down 0.05 rad with motors that do nothing on a floor that takes nothing: what the bearings of the rollers take, and in `bodies` and `articulated`
what it costs to spin up a roller when it comes down.

{energy_against_step()}
## Rollers of a wheel

{lateral_against_rollers()}
## Traction

{traction_against_friction()}
## Slope, wheels locked

{slope_against_friction()}
## Slope, wheels free

{free_rolling_against_rotor()}
## Time step

{errors_against_step()}
The same motions in MuJoCo are in [comparison.md](comparison.md).
"""
    with open(os.path.join(OUT, "validation.md"), "w") as file:
        file.write(page)


if __name__ == "__main__":
    main()
