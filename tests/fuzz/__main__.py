"""A campaign: so many inputs, and what became of them.

Every input follows from seed, target and number alone, so a find can be had again by
`--target NAME --first NUMBER --inputs 1`.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import gc
import io
import multiprocessing
import os
import random
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Sequence
from math import ceil
from pathlib import Path

from drysim.console import problems
from drysim.errors import DrysimError
from fuzz.mutate import damaged
from fuzz.targets import Target, targets
from fuzz.watch import Watch, megabytes

SLOW = 1.0
"""Processor time that an input may take [s]."""

HANG = 60
"""Time after which a campaign gives up on an input, and says where it stands [s]."""

MEMORY = 500
"""Memory that a campaign may ever have [MB]."""

WORDS = 1000
"""Characters of the longest sentence."""

SHOWN = 10
"""Of so many refusals one is shown as a terminal would get it: that costs more than reading."""


def finds_in(fault: DrysimError, show: bool) -> list[str]:
    """Return what is wrong with the words of a refusal."""
    found = getattr(fault, "problems", ()) or [
        p for p in [getattr(fault, "problem", None)] if p
    ]
    sentences = [*(str(fault).splitlines() or [""]), *(problem.sentence for problem in found)]
    wrong = []
    if not all(sentences) or max(map(len, sentences)) > WORDS:
        wrong.append("a sentence is empty or endless")
    if show:
        with contextlib.redirect_stderr(io.StringIO()) as said:
            problems.show_error(fault)
        if not all(sign.isprintable() or sign == "\n" for sign in said.getvalue()):
            wrong.append("a sentence drives the terminal")
    return wrong


def attempt(target: Target, file: Path, given: bytes, watch: Watch, show: bool) -> list[str]:
    """Hand one input to its reader; give what went wrong, last what became of it."""
    watch.paused = True
    file.write_bytes(given)
    watch.paused = False
    wrong: list[str] = []
    began = time.process_time()
    try:
        target.read(file, given)
        end = "read"
    except DrysimError as fault:
        end = "refused"
        wrong = finds_in(fault, show)
    except Exception:
        end = "bug"
        wrong = [traceback.format_exc(limit=-3)]
    watch.paused = True
    if (taken := time.process_time() - began) > SLOW:
        wrong.append(f"it took {taken:.2f} s")
    wrong += watch.noted
    watch.noted.clear()
    return [*wrong, end]


COUNTED = ("read", "refused", "bug", "finds", "next", "megabytes")
"""What a campaign counts, in memory that outlives the process that runs it."""


def campaign(name: str, target: Target, folder: Path, watch: Watch, words: argparse.Namespace,
             inputs: int) -> Counter[str]:  # fmt: skip
    """Fuzz one target; give how many inputs came to what.

    A child process does the work: C code of a reader may end it. That is a find like any other,
    and a new child goes on behind it.
    """
    counts, last = multiprocessing.RawArray("q", len(COUNTED)), words.first + inputs
    at = {word: number for number, word in enumerate(COUNTED)}
    counts[at["next"]] = words.first
    until = time.monotonic() + words.seconds
    while counts[at["next"]] < last and time.monotonic() < until:
        child = os.fork()
        if not child:
            _attempts(name, target, folder, watch, words.seed, last, until, counts)
            os._exit(0)
        if status := os.waitpid(child, 0)[1]:
            number = counts[at["next"]]
            print(f"FIND {name} {number}: the process ended, {status}", file=sys.stderr)
            counts[at["bug"]] += 1
            counts[at["finds"]] += 1
            counts[at["next"]] += 1
    return Counter(dict(zip(COUNTED, counts, strict=True)))


def _attempts(name: str, target: Target, folder: Path, watch: Watch, seed: int, last: int,
              until: float, counts: Sequence[int]) -> None:  # fmt: skip
    """Try one input after the other, from the next one on."""
    at = {word: number for number, word in enumerate(COUNTED)}
    parent = os.getppid()  # without it nobody waits for the finds
    gc.freeze()  # readers collect their garbage, but need not look through all modules for it
    while (number := counts[at["next"]]) < last and time.monotonic() < until:
        if os.getppid() != parent:
            break
        dice = random.Random(f"{seed} {name} {number}")
        given = damaged(target.seeds, dice)
        faulthandler.dump_traceback_later(HANG, exit=True)
        show = number % SHOWN == 0
        *wrong, end = attempt(target, folder / target.file, given, watch, show)
        counts[at[end]] += 1
        counts[at["finds"]] += bool(wrong)
        for sentence in wrong:
            print(f"FIND {name} {number}: {sentence}\n  {given[:200]!r}", file=sys.stderr)
        counts[at["next"]] += 1
        counts[at["megabytes"]] = ceil(megabytes())
    faulthandler.cancel_dump_traceback_later()
    sys.stderr.flush()


def asked() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("--inputs", type=int, default=1_000_000, help="of all targets together")
    parser.add_argument("--seconds", type=float, default=1e9, help="for a target, at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--target", help="one alone")
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    return parser.parse_args()


def main() -> int:
    """Run a campaign; 1 when anything was found."""
    words, total, start = asked(), Counter[str](), time.monotonic()
    print("| target | inputs | read | refused | finds | time |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place:
        folder, watch = Path(place), Watch()
        watch.paused = True
        known = targets(folder)
        chosen = {words.target: known[words.target]} if words.target else known
        shares = sum(target.share for target in chosen.values())
        most = ceil(megabytes())
        before = {file.name for file in folder.iterdir()} | {t.file for t in known.values()}
        for name, target in chosen.items():
            began = time.monotonic()
            inputs = max(1, words.inputs * target.share // shares)
            ends = campaign(name, target, folder, watch, words, inputs)
            show(name, ends, time.monotonic() - began)
            most = max(most, ends["megabytes"])
            total += ends
        strangers = {file.name for file in folder.iterdir()} - before
    show("all", total, time.monotonic() - start)
    print(f"\nmemory: {most} MB at most; files left behind: {len(strangers)}")
    return int(total["finds"] > 0 or most > MEMORY or bool(strangers))


def show(name: str, ends: Counter[str], taken: float) -> None:
    """Show one row."""
    inputs = ends["read"] + ends["refused"] + ends["bug"]
    counts = f"{inputs} | {ends['read']} | {ends['refused']} | {ends['finds']}"
    print(f"| {name} | {counts} | {taken:.0f} s |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
