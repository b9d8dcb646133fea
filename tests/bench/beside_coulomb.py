"""Time one run over a spring contact beside the same scene under coulomb.

    python tests/bench/beside_coulomb.py [--seconds 60] [--repeats 9] [--only "sine 0.5"]

Prints time of the thread relative to coulomb's, medians of interleaved repeats: to follow the
motion without a grid, to have x_r and F_f on its grid, and to follow and measure it. A normal
load that swings is set beside coulomb with limits that swing alike.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator

import numpy as np
from law_scenes import elastic_law
from many import medians

from drysim.approach.solution import Trajectory
from drysim.approach.stick_slip import StickSlip
from drysim.core.compile import MAX_PLAIN_STEPS, choose_engine
from drysim.core.model import (
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
)
from drysim.excitation.random import line_amplitudes, random_signal, spectral_lines
from drysim.metrics.table import measure

PLANT, REST, DT = Plant(75.0, 7500.0, 500.0), State(0.0, 0.0), 2.5e-3
LEVELS, FORCES, STIFFNESSES = (0.5, 1.0), (15.0, 45.0), (1e5, 1e6, 1e7)
SWING = 0.5, 2.0 * math.pi * 2.3, 0.4

Motion = Sines | Samples
Jobs = dict[str, Callable[[], object]]


def motions(a_u: float, seconds: float) -> dict[str, Motion]:
    """Return the base motions of an RMS: noise from 0.5 to 10 Hz, a sine near resonance."""
    wanted = spectral_lines(lambda f: np.ones_like(f), (0.5, 10.0), a_u**2, seconds)
    samples = Samples(random_signal(line_amplitudes(wanted, DT, a_u), 1).u_dd[:], DT)
    return {"samples": samples, "sine": Sines((math.sqrt(2.0) * a_u,), (1.6,), (0.0,))}


def laws(F_fk: float) -> Iterator[tuple[str, dict[str, CoulombLaw | PiecewiseLaw]]]:
    """Return laws to compare, coulomb first."""
    for name, swing in (("jenkins", ()), ("petrov-ewins", SWING)):
        contacts = {f"{k_t:g}": elastic_law(F_fk, k_t, *swing) for k_t in STIFFNESSES}
        yield name, {"coulomb": CoulombLaw(F_fk, F_fk, *swing), **contacts}


def jobs_of(law: CoulombLaw | PiecewiseLaw, motion: Motion, seconds: float) -> Jobs:
    """Return what is timed of one law."""
    scene, solver = (PLANT, law, motion, REST), StickSlip()

    def follow() -> Trajectory:
        """Follow the motion."""
        return solver.trajectory(*scene, seconds)

    def response() -> object:
        """Return it on its grid."""
        found = solver.solve(*scene, DT, seconds)
        return found.x_r, found.F_f

    def metrics() -> object:
        """Follow and measure it."""
        return measure(follow(), (0.1 * seconds, seconds), StrokeLimits(25e-3, 25e-3))

    return {"follow": follow, "response": response, "metrics": metrics}


def events(trajectory: Trajectory) -> int:
    """Return how often the mode changed."""
    return len(trajectory.events)


def compare(
    name: str, shelf: dict[str, CoulombLaw | PiecewiseLaw], motion: Motion, options
) -> None:
    """Print the rows of one law on one base motion."""
    seconds = options.seconds
    each = {word: jobs_of(law, motion, seconds) for word, law in shelf.items()}
    for what in ("follow", "response", "metrics"):
        found = medians(
            {word: jobs[what] for word, jobs in each.items()}, options.repeats, time.thread_time
        )
        reference = found.pop("coulomb")
        row = "  ".join(f"{found[word] / reference:5.2f}" for word in found)
        print(f"{name:34} {what:9} coulomb {1e3 * reference:7.3f} ms   {row}")
    counts = [events(jobs["follow"]()) for jobs in each.values()]
    print(f"{name:34} {'events':9} coulomb {counts[0]:7}      {counts[1:]}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--only", default="", help="words of the rows to print")
    options = parser.parse_args()
    choose_engine(MAX_PLAIN_STEPS + 1)
    print(f"times coulomb at k_t = {', '.join(f'{k_t:g}' for k_t in STIFFNESSES)} N/m")
    for a_u in LEVELS:
        for kind, motion in motions(a_u, options.seconds).items():
            for F_fk in FORCES:
                for name, shelf in laws(F_fk):
                    about = f"{kind} {a_u:g} m/s² {F_fk:g} N {name}"
                    if options.only in about:
                        compare(about, shelf, motion, options)
