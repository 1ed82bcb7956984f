# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares the results of graze for a model with an integration that shares no code with it.

scipy's DOP853 integrates the equations of mechanics.py. The orbit, its events, its Floquet multipliers (by differences of the
period map) and the first Lyapunov exponent of a motion over a few periods (by the growth of the distance of neighbours) are
compared. The motion lies on a chaotic attractor and is the same in both, so that the exponents agree in digits and not only
within standard errors. For some models the special points along a branch are compared too.

usage: against_scipy.py GRAZE_PROGRAM MODEL.toml...
"""
import json
import os
import subprocess
import sys

try:
    import numpy as np
    from scipy.integrate import solve_ivp
except ImportError as error:
    debian = "/usr/bin/python3"  # if another python3 is first on PATH
    if os.path.realpath(sys.executable) != os.path.realpath(debian) and os.path.exists(debian):
        os.execv(debian, [debian] + sys.argv)
    sys.exit(f"{error}: install python3-numpy and python3-scipy (apps/install_packages.sh tests)")

sys.dont_write_bytecode = True
import mechanics

# Required agreement; relative for numbers above 1.
ORBIT = 1e-9  # states, times and speeds
KNOWN = 1e-12  # published values with that many digits
MULTIPLIERS = 1e-6
CRITICAL = 1e-5  # multipliers of 1 or -1 at special points: near grazings the error of differences is 1e-6
EXPONENT = 1e-6  # the relative error of the distance of the neighbours, APART, is about 1e-13 / APART a period

ACCURACY = {"rtol": 1e-12, "atol": 1e-13}
APART = 1e-7
DIFFERENCE = 2e-5  # step of differences
CHATTERING = 1e-4  # slower impacts are not compared: their times accumulate

# Chaotic motions of forced models: the parameters to set, and the number of periods.
CHAOS = {
    "ball-on-table": ({"A": 1.25, "e": 0.9}, 20),
    "beam-two-stops": ({"eta": 1.43, "xi": 0.31, "k_r": 0.84}, 12),
    "capsule": ({"omega": 0.7}, 10),
    "chain-hertz-stop": ({"eta": 1.53, "xi": 1.1, "r": 0.19}, 10),
    "damped-hertz-oscillator": ({"eta": 0.72}, 20),
    "duffing-two-stops": ({"eta": 1.18, "xi": 1.26, "k_r": 0.91}, 20),
    "gear-backlash": ({"F": 0.3, "eta": 1.3}, 20),
    "hertz-beam": ({}, 12),
    "hertz-oscillator": ({"eta": 0.72}, 20),
    "impact-pair": ({"A": 2.25}, 8),
    "linear-beam": ({}, 20),
    "newton-beam": ({}, 20),
    "newton-oscillator": ({"eta": 0.711}, 20),
    "preloaded-stop": ({"eta": 0.96, "xi": 1.44, "k": 48.61, "b": 0.01, "r": 0.57}, 20),
    "rotor-rub": ({"eta": 0.85}, 10),
    "two-mass-chain": ({"omega": 1.17, "A": 1.15, "r": 0.21, "k": 38.92}, 10),
    "two-mass-impact-pair": ({"eta": 0.8}, 10),
}

# Branches of forced models whose special points are compared: options of the command, number of points, known values of some by
# their labels, and the step of differences. The fold of the impact oscillator has an impact of speed 0.004, and the capsule
# grazes near its folds: there the step is smaller.
BRANCHES = {
    "beam-two-stops": (["--to", "1", "--switch", "0"], 2, {}, DIFFERENCE),
    "capsule": (["--to", "0.5", "--switch", "0"], 11, {}, 2e-6),
    "coco-impact-oscillator": (["--param", "A", "--to", "0.09"], 2, {"LP1": 0.0999707536283, "GR1": 0.1}, 2e-7),
    "coco-stick-slip": (["--param", "V", "--from", "0.5", "--to", "0.6", "--settle", "1000"], 1, {}, DIFFERENCE),
    "coco-bang-bang-duffing": (["--to", "0.84", "--switch", "0"], 2, {}, DIFFERENCE),
    "newton-beam": (["--to", "0.5", "--switch", "0"], 1, {}, DIFFERENCE),
    "two-mass-impact-pair": (["--to", "1.16", "--switch", "0"], 1, {}, DIFFERENCE),
}

# Known states at phase 0.
STATES = {"coco-impact-oscillator": [0.870835157464, 1.703821136375]}


def solve(field, begin, end, y, **more):
    solution = solve_ivp(field, (begin, end), y, "DOP853", **ACCURACY, **more)
    if solution.status < 0:
        raise RuntimeError(solution.message)
    return solution


def rate(field, guard, t, y, small=1e-6):
    return (guard(t + small, y + small * np.array(field(t, y))) - guard(t, y)) / small


def polished(field, guard, t0, y0, t):
    """Refines an event near t, which scipy locates by interpolation in its last step, by integration and Newton's method."""
    y = solve(field, t0, t, y0).y[:, -1]
    for _ in range(2):
        rising = rate(field, guard, t, y)
        if rising <= 0.0 or t - guard(t, y) / rising <= t0:
            break
        t -= guard(t, y) / rising
        y = solve(field, t0, t, y0).y[:, -1]
    return t, list(y)


def skipped_step(field, guards, solution):
    """The first step within which a guard seems to rise above zero and to fall again: scipy tests only the ends."""
    for k in range(len(solution.t) - 1):
        (t0, t1), (y0, y1) = solution.t[k:k + 2], solution.y[:, k:k + 2].T
        for guard in guards:
            g0, g1, h = guard(t0, y0), guard(t1, y1), t1 - t0
            if not (g0 < 0.0 and g1 < 0.0):
                continue
            r0, r1 = rate(field, guard, t0, y0), rate(field, guard, t1, y1)
            if r0 > 0.0 > r1:
                s = np.linspace(0.0, 1.0, 50)
                cubic = (g0 * (1 + 2 * s) + h * r0 * s) * (1 - s)**2 + (g1 * (3 - 2 * s) - h * r1 * (1 - s)) * s**2
                if np.max(cubic) > 0.0:
                    return k
    return None


def nearest_approach(flights):
    """The maximum of a contact guard nearest to zero: the contact almost closes, or only just does."""
    heights = []
    for field, guards, begin, end, y in flights:
        for guard in guards:
            top = lambda t, z: rate(field, guard, t, z)
            top.direction = -1.0
            solution = solve(field, begin, end, y, events=[top], max_step=(end - begin) / 50)
            heights += [guard(t, z) for t, z in zip(solution.t_events[0], solution.y_events[0])]
    return min(heights, key=abs)


def carry(system, y, duration, flights=None):
    """Returns the state after the duration, and the events as (kind, time, state before, state after).

    `flights` receives (field, guards of contacts, begin, end, initial state) of each flight from event to event.
    """
    t, mode, happened = 0.0, system.mode(0.0, y), []
    y, fired = list(y), None
    while t < duration:
        field, events, begin = system.fields[mode], [event for event in system.events if event.mode == mode], t

        def watched(guard):
            # A guard that vanishes at the start has just fallen to zero: there it counts as negative.
            left = fired is not None and abs(guard(begin, y)) < 1e-9
            value = lambda s, z: -1.0 if left and s == begin else guard(s, z)
            value.terminal, value.direction = True, 1.0
            return value

        guards = [watched(event.guard) for event in events]
        first = min(1e-4 * duration, duration - t) if fired is not None else None
        solution = solve(field, t, duration, y, events=guards, first_step=first)
        k = skipped_step(field, guards, solution)
        if k is not None:
            t0, t1 = solution.t[k:k + 2]
            solution = solve(field, t0, t1, solution.y[:, k], events=guards, max_step=(t1 - t0) / 50)
        t, y = solution.t[-1], list(solution.y[:, -1])
        if flights is not None:
            contacts = [event.guard for event in events if event.kind in ("enter", "impact")]
            flights.append((field, contacts, solution.t[0], t, solution.y[:, 0]))
        if solution.status == 0:
            fired = None
            continue
        fired = next(event for event, times in zip(events, solution.t_events) if len(times) and times[-1] == t)
        t, before = polished(field, fired.guard, solution.t[-2], solution.y[:, -2], t)
        y, mode = fired.then(t, before)
        y = list(y)
        turned = fired.kind == "stick" and "stick" not in mode  # the mass is not held
        happened.append(("other" if turned else fired.kind, t, before, y))
        if len(happened) > 10000:
            raise RuntimeError(f"more than 10000 events until {t}")
    return np.array(y), happened


def monodromy(system, y, duration, h=DIFFERENCE):
    """Derivative of the map over the duration, by differences with one step of Richardson's extrapolation."""
    n = len(y)
    M = np.zeros((n, n))
    for i in range(n):
        def shifted(h):
            z = np.array(y)
            z[i] += h
            return carry(system, z, duration)[0]

        if system.forward:
            M[:, i] = (shifted(1e-6) - shifted(0.0)) / 1e-6
        else:
            central = lambda h: (shifted(h) - shifted(-h)) / (2 * h)
            M[:, i] = (4 * central(h / 2) - central(h)) / 3
    return M


def first_exponent(system, y, periods):
    """Mean growth per unit of time of the distance between two neighbours, which initially differ in the first state."""
    y, growth = np.array(y), 0.0
    direction = np.eye(len(y))[0]
    for _ in range(periods):
        ahead, y, behind = (carry(system, y + apart * direction, system.period)[0] for apart in (APART, 0.0, -APART))
        distance = np.linalg.norm(ahead - behind)
        direction = (ahead - behind) / distance
        growth += np.log(distance / (2 * APART))
    return growth / (periods * system.period)


class Comparison:
    def __init__(self, name):
        self.name, self.failed = name, False

    def close(self, what, found, expected, tolerance):
        difference = float(np.max(np.abs(np.subtract(found, expected)) / np.maximum(1.0, np.abs(expected)), initial=0.0))
        good = difference <= tolerance
        print(f"{self.name}: {what} agree{'' if good else ' NOT'} to {difference:.1e} (asked {tolerance:g})")
        if not good:
            print(f"  graze {found}\n  scipy {expected}")
            self.failed = True

    def require(self, what, good):
        if not good:
            print(f"{self.name}: {what}")
            self.failed = True


def graze(program, command, file, settings=(), *more):
    arguments = [program, command, file, "--quiet", "--json", "-", *more]
    for name, value in dict(settings).items():
        arguments += ["--set", f"{name}={value!r}"]
    outcome = subprocess.run(arguments, capture_output=True, text=True)
    if outcome.returncode != 0:
        sys.exit(f"{' '.join(arguments)} exits with {outcome.returncode}: {outcome.stderr}")
    return json.loads(outcome.stdout)


def paired(found, expected):
    """The found numbers, sorted so that each expected number has its nearest one."""
    rest, ordered = list(found), []
    for number in expected:
        nearest = min(rest, key=lambda other: abs(other - number))
        rest.remove(nearest)
        ordered.append(nearest)
    return np.array(ordered)


def compare_orbit(comparison, make, result):
    orbit = result["orbit"]
    system = make(result["parameters"])
    state = orbit["state"]
    duration = orbit["duration"] if system.period is None else system.period * orbit["period"]
    end, happened = carry(system, state, duration)
    comparison.close("states after a period", state, end, ORBIT)
    if comparison.name in STATES:
        comparison.close("known states", state, STATES[comparison.name], KNOWN)
    given = orbit["events"]
    kinds = [event["kind"] for event in given]
    chattering = any(event.get("speed", 1.0) < CHATTERING for event in given if event["kind"] == "impact")
    if not chattering:
        comparison.require(f"events are {kinds}, by scipy {[event[0] for event in happened]}",
                           kinds == [event[0] for event in happened])
    pairs = [pair for pair in zip(given, happened) if not (chattering and pair[0].get("speed", 1.0) < CHATTERING)]
    comparison.close(f"times of {len(pairs)} events", [a["tau"] for a, b in pairs], [b[1] for a, b in pairs], ORBIT)
    if not chattering:
        comparison.close("states before them", [a["before"] for a, b in pairs], [b[2] for a, b in pairs], ORBIT)
    expected = np.linalg.eigvals(monodromy(system, state, duration))
    found = [complex(*number) for number in orbit["multipliers"]]
    comparison.close(f"{len(found)} multipliers", paired(found, expected), expected, MULTIPLIERS)


def compare_exponent(comparison, program, file, make, settings, periods):
    attractor = graze(program, "lyapunov", file, settings, "--settle", "200", "--periods", "400")["attractor"]
    comparison.require(f"the attractor at {settings} is {attractor['type']}, not chaotic", attractor["type"] == "chaotic")
    result = graze(program, "lyapunov", file, settings, "--settle", "0", "--periods", str(periods),
                   "--start", ",".join(map(repr, attractor["state"])))
    expected = first_exponent(make(result["parameters"]), attractor["state"], periods)
    nearest = min(result["exponents"], key=lambda number: abs((number or 0.0) - expected))  # graze sorts them
    comparison.close(f"exponents over {periods} chaotic periods", nearest, expected, EXPONENT)


def compare_sides(comparison, result, make, branch, point, step):
    """Compares the multipliers of the points of the branch next to a special point, but not too near, on both sides."""
    for side in (-1, 1):
        beside = [p for p in branch["points"] if side * (p["value"] - point["value"]) > 1e-3]
        near = min(beside, key=lambda p: abs(p["value"] - point["value"]))
        system = make({**result["parameters"], result["options"]["param"]: near["value"]})
        expected = np.linalg.eigvals(monodromy(system, near["state"], branch["period"] * system.period, step))
        found = [complex(*number) for number in near["multipliers"]]
        comparison.close(f"{point['label']}: multipliers at {near['value']:.6g}", paired(found, expected), expected, MULTIPLIERS)


def compare_special_points(comparison, program, file, make, more, count, known, step):
    """Checks that orbits at special points close and that a multiplier is 1 (LP, BP) or -1 (PD) or a guard is touched (GR)."""
    result = graze(program, "continue", file, {}, *more)
    branch = result["branches"][0]
    points = [point for point in branch["special_points"] if point["type"] in ("LP", "BP", "PD", "GR")]
    comparison.require(f"{len(points)} special points, not {count}", len(points) == count)
    for point in points:
        kind, label = point["type"], point["label"]
        if point.get("details", {}).get("kind") == "sliding":  # bracketed: its multipliers jump
            compare_sides(comparison, result, make, branch, point, step)
            continue
        comparison.require(f"{label} is {point['status']}", point["status"] == "converged")
        system = make({**result["parameters"], result["options"]["param"]: point["value"]})
        state, duration = point["state"], branch["period"] * system.period
        if label in known:
            comparison.close(f"{label} at {point['value']:.13g}, known,", point["value"], known[label], KNOWN)
        flights = []
        comparison.close(f"{label}: states after a period", state, carry(system, state, duration, flights)[0], ORBIT)
        if kind == "GR":
            comparison.close(f"{label}: places of the nearest approach", nearest_approach(flights), 0.0, ORBIT)
            continue
        number = -1.0 if kind == "PD" else 1.0
        multipliers = np.linalg.eigvals(monodromy(system, state, duration, step))
        comparison.close(f"{label}: critical multipliers", number, min(multipliers, key=lambda m: abs(m - number)), CRITICAL)


def main():
    program, failed = sys.argv[1], False
    for file in sys.argv[2:]:
        name = os.path.splitext(os.path.basename(file))[0]
        make = getattr(mechanics, name.replace("-", "_"), None)
        if make is None:
            sys.exit(f"{file}: mechanics.py has no equations of it; write {name.replace('-', '_')}(p) from the mechanics")
        comparison = Comparison(name)
        result = graze(program, "orbit", file)
        compare_orbit(comparison, make, result)
        if name in CHAOS:
            compare_exponent(comparison, program, file, make, *CHAOS[name])
        if name in BRANCHES:
            compare_special_points(comparison, program, file, make, *BRANCHES[name])
        failed = failed or comparison.failed
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
