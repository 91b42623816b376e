# MuJoCo's Python bindings are a compiled module without type stubs of its own.
from typing import Any

def __getattr__(name: str) -> Any: ...
