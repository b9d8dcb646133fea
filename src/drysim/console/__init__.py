"""All that the terminal shows: the result on stdout, the talk on stderr. Writes no file."""

from typing import TYPE_CHECKING

from drysim.late import late

if TYPE_CHECKING:
    from drysim.console.bar import progress as progress
    from drysim.console.bench import show_bench as show_bench
    from drysim.console.comparison import show_comparison as show_comparison
    from drysim.console.ensemble import show_ensemble as show_ensemble
    from drysim.console.faults import show_fault as show_fault
    from drysim.console.faults import show_problems as show_problems
    from drysim.console.hard import show_hard as show_hard
    from drysim.console.paper import remark as remark
    from drysim.console.paper import say as say
    from drysim.console.parts import show_warnings as show_warnings
    from drysim.console.retold import show_retold as show_retold
    from drysim.console.retold import told_checks as told_checks
    from drysim.console.summary import show_outcome as show_outcome
    from drysim.console.table import show_interrupted as show_interrupted
    from drysim.console.table import show_table as show_table

__getattr__ = late(
    __name__,
    {
        "drysim.console.bar": "progress",
        "drysim.console.bench": "show_bench",
        "drysim.console.comparison": "show_comparison",
        "drysim.console.ensemble": "show_ensemble",
        "drysim.console.faults": "show_fault show_problems",
        "drysim.console.hard": "show_hard",
        "drysim.console.paper": "remark say",
        "drysim.console.parts": "show_warnings",
        "drysim.console.retold": "show_retold told_checks",
        "drysim.console.summary": "show_outcome",
        "drysim.console.table": "show_interrupted show_table",
    },
)
