#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints one table of ratios from the JSON output of graze_benchmarks.

usage: table.py RESULT.json

Benchmarks are named question/problem/solver. Times are CPU times, the shortest of the repetitions (other work on the machine
only adds to them). `ratio` is a solver's time over that of graze, for the same question and problem in the same run. `growth`
compares the rows of graze within a question with its first row.
"""
import json
import platform
import sys


def processor():
    try:
        with open("/proc/cpuinfo") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or "unknown processor"


def duration(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


SOLVERS = ("graze", "graze-lanes", "graze-general", "by-hand", "gsl-rk8pd", "gsl-rk8pd-signs", "boost-dopri5", "boost-dopri5-signs", "cvode",
           "cvode-signs")
QUESTIONS = ("peak", "period", "flight", "contact", "impact", "orbit", "branch-point", "sweep-row", "impacts", "states")


def order(name):
    """Sort key: questions and solvers as listed above, numbers in problem names (n=16, eta=0.5) by size, eta downwards."""
    question, problem, solver = name.split("/")
    key, _, value = problem.partition("=")
    rank = lambda item, known: known.index(item) if item in known else len(known)
    return rank(question, QUESTIONS), key, (-1 if key == "eta" else 1) * float(value or 0), rank(solver, SOLVERS), name


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        result = json.load(file)
    context = result["context"]
    best, failed = {}, []
    for run in result["benchmarks"]:
        if run.get("run_type") == "aggregate":
            continue
        name = run["run_name"]
        if run.get("error_occurred"):
            failed.append(f"{name}: {run['error_message']}")
        elif name not in best or run["seconds"] < best[name]["seconds"]:
            best[name] = run
    questions = {}
    for name, run in sorted(best.items(), key=lambda item: order(item[0])):
        question, problem, solver = name.split("/")
        questions.setdefault(question, {}).setdefault(problem, {})[solver] = run

    print(f"Processor: {processor()}, {context['num_cpus']} logical processors at {context['mhz_per_cpu']} MHz, "
          f"load {context['load_avg'][0]:.1f} at the start")
    print(f"Compiled (graze and what stands in tests/benchmarks): {context.get('compiler')}, {context.get('flags')}")
    print("GSL and SUNDIALS: the system's shared libraries. All with the 2x2 sensitivity. ratio: time over graze's.")
    print("solver -signs: looks for events only by signs at the ends of a step; the others also for maxima inside a step.")
    print("graze-lanes: many motions side by side (SIMD). graze-general: the flow of systems of one's own.")
    print("error: of state and sensitivity over a period on the attractor, nine in ten are below (orbit: of its state).")
    print("peak: a thousand multiplications and additions, on so many numbers at once; the floor in period.cpp is counted in them.")
    print("miscounted: of 200 runs next to grazing, those with a wrong number of impacts.")
    print()
    head = ("question", "problem", "solver", "time", "ratio", "growth", "tolerance", "error", "miscounted")
    rows = []
    for question, by_problem in questions.items():
        first = None
        for problem, by_solver in by_problem.items():
            ours = by_solver.get("graze")
            for solver, run in by_solver.items():
                number = lambda key, form: format(run[key], form) if key in run else ""
                growth = ""
                if solver == "graze" and question in ("orbit", "impacts", "states"):
                    first = first or run["seconds"]
                    growth = f"{run['seconds'] / first:.2f}"
                label = problem
                if question == "impacts":
                    label += f" ({run['impacts']:.3g} impacts)"
                rows.append((question, label, solver, duration(run["seconds"]),
                             f"{run['seconds'] / ours['seconds']:.1f}" if ours else "", growth, number("tolerance", ".0e"),
                             number("error", ".1e"), number("miscounted", ".0f")))
    widths = [max(len(row[i]) for row in rows + [head]) for i in range(len(head))]
    line = lambda row: "  ".join(cell.ljust(w) if i < 3 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))).rstrip()
    print(line(head))
    before = None
    for row in rows:
        if before and row[:2] != before[:2]:
            print()
        print(line(row))
        before = row
    if failed:
        sys.exit("failed: " + "; ".join(sorted(set(failed))))


main()
