"""What runs inside the simulation kernel: how it is marked, what it is given, what it shares.

Controllers and tasks are described here and there in the library, and part of each description is
code that runs thousands of times a second. Such a function is marked with `compiled` and stays an
ordinary Python function, cheap to import and easy to test; `lfr.sim.compilation` compiles what is
marked together with the kernel that calls it.
"""

from lfr.compiled.marking import MARKED, compiled, select

__all__ = ["MARKED", "compiled", "select"]
