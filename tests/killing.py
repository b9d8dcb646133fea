"""Kill -9 at any instant of what is written."""

from __future__ import annotations

import os
import sys
import warnings


def killed_at(step, act):
    """Run `act` in a process that dies at its n-th line in report/; True when it does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        left = step

        def trace(frame, event, _):
            nonlocal left
            if "/report/" not in frame.f_code.co_filename:
                return None
            left -= event == "line"
            if left < 0:
                os._exit(9)
            return trace

        sys.settrace(trace)
        act()
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
