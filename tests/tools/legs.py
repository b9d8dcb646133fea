"""Legs of a state machine: by an integrator from one change of mode or kink to the next."""

from __future__ import annotations


def event(function, direction):
    """Make a function of t and y an event that ends a leg where it falls or rises."""
    function.terminal, function.direction = True, direction
    return function


def leg(rates, t, y, duration, kinks, events, rtol):
    """Go on from a state by scipy's DOP853 to a relative tolerance.

    Returns
    -------
    t, y, solution, hit
        Where the leg ends, the way there, and the number of the event that ended it, or None.
    """
    from scipy.integrate import solve_ivp

    until = min([duration, *(kink for kink in kinks if kink > t)][:2])
    found = solve_ivp(
        rates, (t, until), y, "DOP853", events=events, rtol=rtol, atol=1e-3 * rtol,
        max_step=2e-3, dense_output=True,
    )  # fmt: skip
    hit = [i for i, times in enumerate(found.t_events) if len(times)]
    return found.t[-1], found.y[:, -1], found.sol, hit[0] if hit else None
