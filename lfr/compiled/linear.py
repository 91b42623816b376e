"""Small linear algebra on symmetric matrices, for the compiled kernel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled.marking import compiled


@compiled
def factorise(A: NDArray[np.float64], n: int) -> None:
    """Lower Cholesky factor in place; a direction without inertia gets no force (as by pinv)."""
    for i in range(n):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                A[i, i] = math.sqrt(total) if total > 1e-14 else 1e30
            else:
                A[i, j] = total / A[j, j]


@compiled
def solve(L: NDArray[np.float64], n: int, x: NDArray[np.float64], offset: int) -> None:
    """x[offset:offset+n] <- (L L^T)^-1 x."""
    for i in range(n):
        total = x[offset + i]
        for k in range(i):
            total -= L[i, k] * x[offset + k]
        x[offset + i] = total / L[i, i]
    for i in range(n - 1, -1, -1):
        total = x[offset + i]
        for k in range(i + 1, n):
            total -= L[k, i] * x[offset + k]
        x[offset + i] = total / L[i, i]
