"""What tests ask about other processes."""

from pathlib import Path


def ended(pid: int) -> bool:
    """Whether a process has ended, though nobody may have collected its exit code yet.

    Not every container's first process collects the processes that it inherits.
    """
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True
    return stat.rpartition(")")[2].split()[0] in "ZX"
