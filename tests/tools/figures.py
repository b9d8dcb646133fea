"""Print how large the package is and how it hangs together: `python tests/tools/figures.py`.

Files and lines, modules that simple commands execute, and import circles with type-checking
imports and imports within functions counted.
"""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

HOME = Path(__file__).parents[2] / "src" / "drysim"

SCENARIO = """
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
excitation: {kind: harmonic, frequency: 2, amplitude: 1}
measure: {duration: 2}
solver: {step: 0.01}
"""


def modules() -> dict[str, Path]:
    """Return the source file of every module of the package."""
    files = sorted(HOME.rglob("*.py"))
    named = {
        ".".join(("drysim", *file.relative_to(HOME).with_suffix("").parts)): file
        for file in files
    }
    return {name.removesuffix(".__init__"): file for name, file in named.items()}


def imported(file: Path, known: dict[str, Path]) -> set[str]:
    """Return the modules of the package that a file imports anywhere."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in known else node.module)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name in known}


def circle(known: dict[str, Path]) -> list[str]:
    """Return the modules of an import circle; nothing where there is none."""
    graph = {name: imported(file, known) - {name} for name, file in known.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as fault:
        return list(fault.args[1])
    return []


def executed(*words: str) -> int:
    """Return how many files of the package a command executes."""
    program = (
        "import sys; from drysim.cli import main; main(sys.argv[1:]); "
        "names = [m for m in sys.modules.values() if getattr(m, '__file__', None)"
        " and m.__name__.split('.')[0] == 'drysim']; print(len(names), file=sys.stderr)"
    )
    with tempfile.TemporaryDirectory() as folder:
        sweep = "sweep: {excitation.frequency: [1, 2, 3]}\n" if words[0] == "sweep" else ""
        Path(folder, "s.yaml").write_text(SCENARIO + sweep)
        done = subprocess.run(
            [sys.executable, "-c", program, *words], cwd=folder, capture_output=True, text=True
        )
    return int(done.stderr.split()[-1])


if __name__ == "__main__":
    known = modules()
    print(f"files {len(known)}")
    print(f"lines {sum(file.read_text().count(chr(10)) for file in known.values())}")
    print(f"run executes {executed('run', 's.yaml', '--no-plots', '--quiet')} files")
    print(f"sweep executes {executed('sweep', 's.yaml', '--no-plots', '--quiet')} files")
    print(f"import circle: {' > '.join(circle(known)) or 'none'}")
