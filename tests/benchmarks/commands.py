#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Times whole commands of graze: the gain of lanes over single motions, and of two threads over one.

Each command, such as `graze sweep` of the damped Hertz oscillator, is run in four ways in turn, so that other work on the
machine affects all of them equally. The shortest time of N rounds counts (default 2):
  one    on one thread
  two    on two threads
  pair   two copies at once, on one thread each
  alone  on one thread with --flow alone: each motion by itself (once, and only if --alone is given; it takes the longest)
`threads` is one / two. `capacity`, 2 one / pair, is the largest possible gain of two processors of the machine: they share
clock, caches and memory, and may be hyperthreads of one core. `of it` is threads / capacity. `lanes` compares the processor
time of alone with that of one.
"""
import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

PROBLEMS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "problems")
LINEAR_STOP = """[model]
oscillator = "linear"
contact = "linear"
[parameters]
b = 0.05
xi = 1.0
eta = 0.95
r = 1.0
beta = 0.0
k_S = 25.0
"""
# Problem file (None: the one above); columns and rows of maps, random starts, ranges of eta and steps of the two sweeps.
OSCILLATOR_MAP, CANTILEVER_MAP = ("eta:0.65:0.95:400", "r:1:3:300"), ("eta:0.45:0.65:100", "r:0.06:0.1:80")
SYSTEMS = {
    "newton": ("newton-elastic", OSCILLATOR_MAP, 1000000, ("0.6", "1.2", "0.000003125"), ("0.7", "0.75", "0.000003125")),
    "hertz": ("hertz-damped", OSCILLATOR_MAP, 262144, ("0.6", "1.2", "0.000025"), ("0.7", "0.75", "0.000025")),
    "linear": (None, OSCILLATOR_MAP, 1000000, ("0.4", "1", "0.0000125"), ("0.54", "0.56", "0.000003125")),
    "beam-newton": ("beam-newton", CANTILEVER_MAP, 32768, ("0.45", "0.65", "0.0000625"), ("0.54", "0.56", "0.0000125")),
    "beam-hertz": ("beam-hertz", CANTILEVER_MAP, 16384, ("0.45", "0.65", "0.000125"), ("0.54", "0.56", "0.00005")),
    "beam-linear": ("beam-linear", CANTILEVER_MAP, 16384, ("0.45", "0.65", "0.0000625"), ("0.54", "0.56", "0.000025")),
}


def commands(folder):
    """Name and arguments of each command. The name of its output file is appended later."""
    out = {}
    own = os.path.join(folder, "linear-stop.toml")
    with open(own, "w") as file:
        file.write(LINEAR_STOP)
    for system, (problem, grid, starts, whole, chaotic) in SYSTEMS.items():
        file = os.path.join(PROBLEMS, problem + ".toml") if problem else own
        grid = ["--param", grid[0], "--param", grid[1]]
        out[f"map/{system}"] = ["map", file, *grid, "--h5"]
        out[f"map-follow/{system}"] = ["map", file, *grid, "--follow", "up", "--h5"]
        out[f"attractors/{system}"] = ["attractors", file, "--random", str(starts), "--csv"]
        for name, (lower, upper, step) in (("sweep", whole), ("chaotic", chaotic)):
            for direction in ("up", "down"):
                out[f"{name}-{direction}/{system}"] = ["sweep", file, "--from", lower, "--to", upper, "--step", step, "--direction",
                                                       direction, "--csv"]
    return out


def run(graze, arguments, folder, threads, copies=1, more=()):
    """Wall and processor time of `copies` simultaneous copies, in seconds."""
    files = [os.path.join(folder, f"result-{k}.h5" if arguments[0] == "map" else f"result-{k}.csv") for k in range(copies)]
    for file in files:
        if os.path.exists(file):
            os.remove(file)
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    started = [subprocess.Popen([graze, "--quiet", "--threads", str(threads), *arguments, file, *more], stdout=subprocess.DEVNULL)
               for file in files]
    if any([process.wait() != 0 for process in started]):
        sys.exit("failed: graze " + " ".join(arguments))
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("graze", metavar="GRAZE", help="the program")
    parser.add_argument("--rounds", type=int, default=2, metavar="N")
    parser.add_argument("--only", default="", metavar="TEXT", help="commands whose name holds TEXT")
    parser.add_argument("--alone", action="store_true", help="also each motion by itself")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        head = ("command", "one", "two", "pair", "threads", "capacity", "of it", "lanes")
        print("{:26}".format(head[0]) + "".join(f"{name:>10}" for name in head[1:]), flush=True)
        for name, arguments in commands(folder).items():
            if options.only not in name:
                continue
            one, two, pair = [], [], []
            for _ in range(max(1, options.rounds)):
                one.append(run(options.graze, arguments, folder, 1))
                pair.append(run(options.graze, arguments, folder, 1, copies=2))
                two.append(run(options.graze, arguments, folder, 2))
            lanes = ""
            if options.alone:
                alone = run(options.graze, arguments, folder, 1, more=("--flow", "alone"))
                lanes = f"{alone[1] / min(cpu for _, cpu in one):.2f}"
            wall = [min(times)[0] for times in (one, two, pair)]
            threads, capacity = wall[0] / wall[1], 2 * wall[0] / wall[2]
            print(f"{name:26}" + "".join(f"{seconds:>8.2f} s" for seconds in wall) +
                  f"{threads:>10.2f}{capacity:>10.2f}{threads / capacity:>10.2f}{lanes:>10}", flush=True)


main()
