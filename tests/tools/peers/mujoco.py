"""MuJoCo: dry friction as a soft constraint of a slide joint, with fixed steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from drysim.bench.scipy_ivp import has_static_excess
from drysim.bench.work import Answer, Entry, Run, Work

if TYPE_CHECKING:
    from drysim.core.model import Floats


PACKAGE = "mujoco"

SUBSTEPS = (1, 8)
"""Numbers of steps per sample."""

MODEL_XML = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="implicitfast" tolerance="0">
    <flag contact="disable"/>
  </option>
  <worldbody><body>
    <joint name="slide" type="slide" axis="1 0 0" stiffness="{k_x}" damping="{b}"
      frictionloss="{F_fk}" solreffriction="{softness} 1"/>
    <geom type="sphere" size="0.1" mass="{m}"/>
  </body></worldbody>
  <actuator><motor joint="slide"/></actuator>
</mujoco>
"""
"""The oscillator in the frame of its base, under the inertial force -m ü."""

SOFTNESS = 2.0
"""Time constant of the friction constraint in steps: the least that MuJoCo accepts."""


def entries(work: Work) -> Iterator[Entry]:
    """Yield MuJoCo at several steps."""
    for substeps in SUBSTEPS:
        step = work.step / substeps
        yield Entry(
            "MuJoCo",
            "implicitfast",
            with_step(substeps),
            step,
            substeps,
            other_law=has_static_excess(work),
        )


def with_step(substeps: int) -> Callable[[Work], Run]:
    """Return the preparation of an entry with a number of steps per sample."""

    def ready(work: Work) -> Run:
        import mujoco
        from mujoco.rollout import rollout

        (m, k_x, b), F_fk, step = work.plant, work.law.F_fk, work.step / substeps
        words = MODEL_XML.format(
            m=m, k_x=k_x, b=b, F_fk=F_fk, step=step, softness=SOFTNESS * step
        )  # fmt: skip
        model = mujoco.MjModel.from_xml_string(words)
        scene = mujoco.MjData(model)
        at = np.arange(work.samples * substeps) / substeps
        push = -m * np.interp(at, np.arange(work.samples + 1), work.u_dd)
        begin = np.array([[0.0, *work.start]])

        def run() -> Answer:
            passed, _ = rollout(model, scene, begin, push[None, :, None])
            state = np.vstack((begin, passed[0]))[::substeps]
            x_r, v_r = state[:, 1], state[:, 2]
            return Answer(x_r, v_r, lambda: friction_from_motion(work, x_r, v_r))

        return run

    return ready


def friction_from_motion(work: Work, x_r: Floats, v_r: Floats) -> Floats:
    """Return F_f [N] from the motion, as MuJoCo does not record its constraint force."""
    m, k_x, b = work.plant
    v_d = np.gradient(v_r, work.step)
    friction: Floats = -m * (v_d + work.u_dd) - k_x * x_r - b * v_r
    return friction
