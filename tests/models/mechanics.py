# SPDX-License-Identifier: GPL-3.0-or-later
"""An independent version of the shipped models, written by hand from the mechanics without their files.

Each function takes the parameters by name and returns a System. Forces are written body by body, contacts as free or closed,
friction as sticking or sliding in one direction, so that every field is smooth between two events.
"""
from dataclasses import dataclass, field
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Callable, Optional


@dataclass
class Event:
    """Occurs where guard(t, y) rises through zero in the mode; then(t, y) gives the next state and mode."""

    kind: str
    mode: str
    guard: Callable
    then: Callable


@dataclass
class System:
    fields: dict  # mode -> f(t, y), the derivative of y
    events: list
    mode: Callable  # mode of an initial state: mode(t, y)
    period: Optional[float] = None  # of the forcing; None: autonomous
    forward: bool = False  # the state lies at a stop: one-sided differences only


def sign(x):
    return 1.0 if x > 0.0 else -1.0


def rigid_stop(place, restitution, side, x=0, v=1):
    """Impact of a coordinate x with speed v at a stop to the right (side = 1) or to the left (-1) of it."""

    def rebound(t, y):
        z = list(y)
        z[x], z[v] = place, -restitution * y[v]
        return z, "free"

    return Event("impact", "free", lambda t, y: side * (y[x] - place), rebound)


def soft_stop(gap):
    """Contact begins where the gap closes, and ends where it opens."""
    return [Event("enter", "free", lambda t, y: -gap(y), lambda t, y: (y, "contact")),
            Event("leave", "contact", lambda t, y: gap(y), lambda t, y: (y, "free"))]


def one_mass(p, load, stops=(), contact=None, place=None):
    """A mass of 1 under load(t, x, v), with rigid stops, or with contact(depth, rate) beyond a place."""
    fields = {"free": lambda t, y: (y[1], load(t, y[0], y[1]))}
    events = list(stops)
    mode = lambda t, y: "free"
    if contact:
        fields["contact"] = lambda t, y: (y[1], load(t, y[0], y[1]) - contact(max(y[0] - place, 0.0), y[1]))
        events += soft_stop(lambda y: place - y[0])
        mode = lambda t, y: "contact" if y[0] > place else "free"
    return System(fields, events, mode, 2 * pi / p["eta"])


def oscillator_load(p, beta=0.0):
    def load(t, x, v):
        spring, damper, drive = x + beta * x * x * x, 2 * p["b"] * v, p["xi"] * cos(p["eta"] * t)
        return drive - spring - damper

    return load


def newton_oscillator(p):
    return one_mass(p, oscillator_load(p), [rigid_stop(p["r"], p["k_r"], 1)])


def hertz_oscillator(p):
    return one_mass(p, oscillator_load(p), contact=lambda d, u: p["k_H"] * d * sqrt(d) * (1 + p["b_H"] * u), place=p["r"])


damped_hertz_oscillator = hertz_oscillator


def newton_beam(p):
    return one_mass(p, oscillator_load(p, p["beta"]), [rigid_stop(p["r"], p["k_r"], 1)])


def linear_beam(p):
    return one_mass(p, oscillator_load(p, p["beta"]), contact=lambda d, u: p["k_S"] * d, place=p["r"])


def hertz_beam(p):
    return one_mass(p, oscillator_load(p, p["beta"]), contact=lambda d, u: p["k_H"] * d * sqrt(d) * (1 + p["b_H"] * u),
                    place=p["r"])


def beam_two_stops(p):
    return one_mass(p, oscillator_load(p, p["beta"]), [rigid_stop(p["r"], p["k_r"], 1), rigid_stop(-p["l"], p["k_r"], -1)])


def duffing_two_stops(p):
    return one_mass(p, oscillator_load(p, p["beta"]), [rigid_stop(p["r"], p["k_r"], 1), rigid_stop(-p["r"], p["k_r"], -1)])


def preloaded_stop(p):
    return one_mass(p, oscillator_load(p), contact=lambda d, u: p["P"] + p["k"] * d, place=p["r"])


def gear_backlash(p):
    """The teeth touch in front (x > 1), behind (x < -1) or not at all."""

    def flank(push):
        return lambda t, y: (y[1], p["F_m"] + p["F"] * cos(p["eta"] * t) - 2 * p["z"] * y[1] - push(y[0]))

    fields = {"front": flank(lambda x: x - 1), "none": flank(lambda x: 0.0), "behind": flank(lambda x: x + 1)}
    events = [Event("other", "front", lambda t, y: 1 - y[0], lambda t, y: (y, "none")),
              Event("other", "none", lambda t, y: y[0] - 1, lambda t, y: (y, "front")),
              Event("other", "none", lambda t, y: -1 - y[0], lambda t, y: (y, "behind")),
              Event("other", "behind", lambda t, y: y[0] + 1, lambda t, y: (y, "none"))]
    return System(fields, events, lambda t, y: "front" if y[0] > 1 else "behind" if y[0] < -1 else "none", 2 * pi / p["eta"])


def impact_pair(p):
    """The ball moves at a constant speed; its acceleration relative to the box is minus that of the box."""
    box_acceleration = lambda t: -p["A"] * p["omega"]**2 * sin(p["omega"] * t)
    return System({"free": lambda t, y: (y[1], -box_acceleration(t))},
                  [rigid_stop(1.0, p["e"], 1), rigid_stop(-1.0, p["e"], -1)], lambda t, y: "free", 2 * pi / p["omega"])


def ball_on_table(p):
    table_acceleration = lambda t: -p["A"] * p["omega"]**2 * sin(p["omega"] * t)
    return System({"free": lambda t, y: (y[1], -p["g"] - table_acceleration(t))}, [rigid_stop(0.0, p["e"], -1)],
                  lambda t, y: "free", 2 * pi / p["omega"])


def ball(p):
    """Ball over a still frame; the table moves. After complete chattering it rests until the table falls faster than it."""
    w, slowest = p["omega"], 1e-9
    table = lambda t: p["A"] * sin(w * t)
    speed = lambda t: p["A"] * w * cos(w * t)
    acceleration = lambda t: -p["A"] * w * w * sin(w * t)

    def rebound(t, y):
        away = -p["e"] * (y[1] - speed(t))
        if away < slowest and acceleration(t) > -p["g"]:
            return [table(t), speed(t)], "rest"
        return [table(t), speed(t) + away], "free"

    fields = {"free": lambda t, y: (y[1], -p["g"]), "rest": lambda t, y: (speed(t), acceleration(t))}
    events = [Event("impact", "free", lambda t, y: table(t) - y[0], rebound),
              Event("release", "rest", lambda t, y: -p["g"] - acceleration(t), lambda t, y: (y, "free"))]
    resting = lambda t, y: abs(y[0] - table(t)) < 1e-12 and abs(y[1] - speed(t)) < 1e-12 and acceleration(t) > -p["g"]
    return System(fields, events, lambda t, y: "rest" if resting(t, y) else "free", 2 * pi / w, forward=True)


def two_mass_chain(p):
    """Two masses of 1 between two walls: springs 1, kappa, 1, three dampers c; an elastic stop beyond the second mass."""

    def forces(closed):
        def f(t, y):
            x1, x2, v1, v2 = y
            between = p["kappa"] * (x2 - x1) + p["c"] * (v2 - v1)  # on the first mass
            left, right = -x1 - p["c"] * v1, -x2 - p["c"] * v2
            stop = p["k"] * (x2 - p["r"]) if closed else 0.0
            shaker = p["A"] * p["omega"]**2 * cos(p["omega"] * t)
            return v1, v2, shaker + left + between, right - between - stop

        return f

    return System({"free": forces(False), "contact": forces(True)}, soft_stop(lambda y: p["r"] - y[1]),
                  lambda t, y: "contact" if y[1] > p["r"] else "free", 2 * pi / p["omega"])


def chain_hertz_stop(p):
    """Masses m and 1; spring k and damper c to the ground, kappa and c between the masses; a damped Hertz stop."""

    def forces(closed):
        def f(t, y):
            x1, x2, v1, v2 = y
            between = p["kappa"] * (x2 - x1) + p["c"] * (v2 - v1)
            ground = -p["k"] * x1 - p["c"] * v1
            depth = max(x2 - p["r"], 0.0)
            stop = p["k_H"] * depth * sqrt(depth) * (1 + p["b_H"] * v2) if closed else 0.0
            return v1, v2, (p["xi"] * cos(p["eta"] * t) + ground + between) / p["m"], -between - stop

        return f

    return System({"free": forces(False), "contact": forces(True)}, soft_stop(lambda y: p["r"] - y[1]),
                  lambda t, y: "contact" if y[1] > p["r"] else "free", 2 * pi / p["eta"])


def rotor_rub(p):
    """Shaft of stiffness 1; the ring pushes it towards the centre with k times the depth."""

    def forces(closed):
        def f(t, y):
            radius, angle = hypot(y[0], y[1]), atan2(y[1], y[0])
            ring = p["k"] * (radius - 1) if closed else 0.0
            unbalance, turn = p["eps"] * p["eta"]**2, p["eta"] * t
            return (y[2], y[3], unbalance * cos(turn) + p["s"] - y[0] - 2 * p["b"] * y[2] - ring * cos(angle),
                    unbalance * sin(turn) - y[1] - 2 * p["b"] * y[3] - ring * sin(angle))

        return f

    return System({"free": forces(False), "contact": forces(True)}, soft_stop(lambda y: 1 - hypot(y[0], y[1])),
                  lambda t, y: "contact" if hypot(y[0], y[1]) > 1 else "free", 2 * pi / p["eta"])


def two_mass_impact_pair(p):
    """Restitution of the relative speed; the total momentum is conserved."""

    def free(t, y):
        x1, x2, v1, v2 = y
        return v1, v2, p["xi"] * cos(p["eta"] * t) - x1 - p["beta"] * x1**3 - 2 * p["b"] * v1, 0.0

    def collide(side):
        def then(t, y):
            x1, x2, v1, v2 = y
            centre = (v1 + p["mu"] * v2) / (1 + p["mu"])
            relative = -p["k_r"] * (v2 - v1)
            share = relative / (1 + p["mu"])
            return [x1, x1 + side * p["r"], centre - p["mu"] * share, centre + share], "free"

        return Event("impact", "free", lambda t, y: side * (y[1] - y[0]) - p["r"], then)

    return System({"free": free}, [collide(1), collide(-1)], lambda t, y: "free", 2 * pi / p["eta"])


def capsule(p):
    """Inner mass of 1 (y: speed y[1]) on a spring and damper in the capsule (speed y[2]); friction of at most 1 under it."""

    def inner_force(y, closed):
        return y[0] + 2 * p["z"] * (y[1] - y[2]) + (p["beta"] * (y[0] - p["delta"]) if closed else 0.0)

    fields, events = {}, []
    for name, closed in (("free", False), ("contact", True)):
        force = lambda y, closed=closed: inner_force(y, closed)
        move = lambda friction, force=force: lambda t, y: (y[1] - y[2], p["alpha"] * cos(p["omega"] * t) - force(y),
                                                           (force(y) + friction) / p["gamma"])
        fields[name, "forward"] = move(-1.0)
        fields[name, "backward"] = move(1.0)
        fields[name, "stick"] = lambda t, y, force=force: (y[1], p["alpha"] * cos(p["omega"] * t) - force(y), 0.0)

        def at_rest(t, y, force=force, name=name):
            push = force((y[0], y[1], 0.0))
            return [y[0], y[1], 0.0], (name, "stick" if abs(push) < 1 else "forward" if push > 0 else "backward")

        events += [Event("stick", (name, "forward"), lambda t, y: -y[2], at_rest),
                   Event("stick", (name, "backward"), lambda t, y: y[2], at_rest),
                   Event("release", (name, "stick"), lambda t, y, force=force: force(y) - 1,
                         lambda t, y, name=name: (y, (name, "forward"))),
                   Event("release", (name, "stick"), lambda t, y, force=force: -force(y) - 1,
                         lambda t, y, name=name: (y, (name, "backward")))]
    for motion in ("forward", "backward", "stick"):
        def touch(t, y, motion=motion):
            if motion == "stick" and abs(inner_force(y, True)) > 1:
                motion = "forward" if inner_force(y, True) > 0 else "backward"
            return y, ("contact", motion)

        events += [Event("enter", ("free", motion), lambda t, y: y[0] - p["delta"], touch),
                   Event("leave", ("contact", motion), lambda t, y: p["delta"] - y[0],
                         lambda t, y, motion=motion: (y, ("free", motion)))]

    def mode(t, y):
        contact = "contact" if y[0] > p["delta"] else "free"
        if y[2] != 0.0:
            return contact, "forward" if y[2] > 0 else "backward"
        push = inner_force(y, contact == "contact")
        return contact, "stick" if abs(push) < 1 else "forward" if push > 0 else "backward"

    return System(fields, events, mode, 2 * pi / p["omega"])


def block_on_belt(p):
    """Friction mu/(1 + delta u) at the sliding speed u drags the block along with the belt; mu is the static limit."""
    V = p["V"]
    friction = lambda u: p["mu"] / (1 + p["delta"] * u)
    held = lambda y: y[0] + p["c"] * V  # the force that holds a sticking block
    fields = {"slower": lambda t, y: (y[1], -y[0] - p["c"] * y[1] + friction(V - y[1])),
              "faster": lambda t, y: (y[1], -y[0] - p["c"] * y[1] - friction(y[1] - V)),
              "stick": lambda t, y: (V, 0.0)}

    def meet(t, y):
        z = [y[0], V]
        return z, "stick" if abs(held(z)) < p["mu"] else "slower" if held(z) > 0 else "faster"

    events = [Event("stick", "slower", lambda t, y: y[1] - V, meet), Event("stick", "faster", lambda t, y: V - y[1], meet),
              Event("release", "stick", lambda t, y: held(y) - p["mu"], lambda t, y: (y, "slower")),
              Event("release", "stick", lambda t, y: -held(y) - p["mu"], lambda t, y: (y, "faster"))]
    return System(fields, events, lambda t, y: "slower" if y[1] < V else "faster" if y[1] > V else meet(t, y)[1])


def relief_valve(p):
    """Spring with pretension and damper on the disc; the chamber is filled with q and emptied through the open valve."""
    return System({"free": lambda t, y: (y[1], y[2] - (p["delta"] + y[0]) - p["kappa"] * y[1],
                                         p["beta"] * (p["q"] - y[0] * sqrt(y[2])))},
                  [rigid_stop(0.0, p["r"], -1)], lambda t, y: "free")


def rimless_wheel(p):
    """Inverted pendulum; at heel strike the angular momentum about the new contact point is conserved."""

    def strike(t, y):
        return [p["gamma"] - p["alpha"], y[1] * cos(2 * p["alpha"])], "stance"

    return System({"stance": lambda t, y: (y[1], sin(y[0]))},
                  [Event("impact", "stance", lambda t, y: y[0] - (p["gamma"] + p["alpha"]), strike)], lambda t, y: "stance")


def coco_impact_oscillator(p):
    load = lambda t, y: (y[1], p["A"] * cos(p["w"] * t) - p["k"] * y[0] - p["c"] * y[1])
    return System({"free": load}, [rigid_stop(p["d"], p["e"], 1)], lambda t, y: "free", 2 * pi / p["w"])


def coco_stick_slip(p):
    """The sliding mass is brought to rest by a constant force, and by the force of spring and field on the other mass."""
    def force(t, q, v):
        field = (p["V"] * sin(p["w"] * t) / (1 - q))**2
        return field - q - p["c"] * v

    def collide(t, y):
        return [0.5, -p["e"] * y[1], (1 + p["e"]) * y[1] / 6], "slip"

    fields = {"stick": lambda t, y: (y[1], force(t, y[0], y[1]), 0.0),
              "slip": lambda t, y: (y[1], p["n"] + 1.2 * force(t, y[0], y[1]), -p["n"] - 0.2 * force(t, y[0], y[1]))}
    events = [Event("impact", "stick", lambda t, y: y[0] - 0.5, collide),
              Event("stick", "slip", lambda t, y: -y[2], lambda t, y: ([y[0], y[1], 0.0], "stick"))]
    # While the mass sticks, u is not a state. An orbit begins in this mode, and differences in u must not start a slip.
    return System(fields, events, lambda t, y: "stick", pi / p["w"])


def coco_bang_bang_duffing(p):
    def driven(force):
        return lambda t, y: (y[1], force - p["la"] * y[1] - p["al"] * y[0] - p["eps"] * y[0]**3)

    fields = {"push": driven(p["A"]), "pull": driven(-p["A"])}
    events = [Event("other", "push", lambda t, y: -cos(p["om"] * t), lambda t, y: (y, "pull")),
              Event("other", "pull", lambda t, y: cos(p["om"] * t), lambda t, y: (y, "push"))]
    return System(fields, events, lambda t, y: "push" if cos(p["om"] * t) > 0 else "pull", 2 * pi / p["om"])
