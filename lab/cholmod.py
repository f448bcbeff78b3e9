# SPDX-License-Identifier: GPL-2.0-or-later
"""CHOLMOD, the sparse Cholesky factorisation of SuiteSparse, by its C interface: SciPy has none, and its LU takes ten
times the memory of a solid's factor."""

from ctypes.util import find_library
from typing import Any

import cffi
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lab import LabError

_ffi = cffi.FFI()
_ffi.cdef("""
typedef struct { size_t nrow, ncol, nzmax; void *p, *i, *nz, *x, *z; int stype, itype, xtype, dtype, sorted, packed;
} cholmod_sparse;
typedef struct { size_t nrow, ncol, nzmax, d; void *x, *z; int xtype, dtype; } cholmod_dense;
typedef struct { size_t n, minor; void *Perm, *ColCount, *IPerm; size_t nzmax; void *p, *i, *x, *z, *nz, *next, *prev;
    size_t nsuper, ssize, xsize, maxcsize, maxesize; void *super, *pi, *px, *s;
    int ordering, is_ll, is_super, is_monotonic, itype, xtype, dtype, useGPU; } cholmod_factor;
int cholmod_start(void *);
int cholmod_metis(cholmod_sparse *, int *, size_t, int, int *, void *);
cholmod_factor *cholmod_analyze_p(cholmod_sparse *, int *, int *, size_t, void *);
int cholmod_factorize(cholmod_sparse *, cholmod_factor *, void *);
int cholmod_change_factor(int, int, int, int, int, cholmod_factor *, void *);
cholmod_dense *cholmod_solve(int, cholmod_factor *, cholmod_dense *, void *);
int cholmod_free_factor(cholmod_factor **, void *);
int cholmod_free_dense(cholmod_dense **, void *);
void openblas_set_num_threads(int);
""")
_COMMON_BYTES = 1 << 16  # more than any version's workspace descriptor
_REAL, _LOWER, _SOLVE = 1, -1, 0


def _library() -> Any:
    if (name := find_library("cholmod")) is None:
        raise LabError("libcholmod: is not there; run sh scripts/setup.sh")
    return _ffi.dlopen(name)


class Factor:
    """K = L L^T of a symmetric positive definite matrix [n, n]. Raises LabError where it is not definite."""

    def __init__(self, k: sp.spmatrix) -> None:
        self._lib = _library()
        self._common = _ffi.new("char[]", _COMMON_BYTES)
        self._lib.cholmod_start(self._common)
        lower = sp.tril(k, format="csc")
        lower.sort_indices()
        p, i, x = lower.indptr.astype(np.int32), lower.indices.astype(np.int32), lower.data.astype(np.float64)
        matrix = _ffi.new("cholmod_sparse*", {
            "nrow": k.shape[0], "ncol": k.shape[1], "nzmax": len(x), "p": _ffi.from_buffer(p), "i": _ffi.from_buffer(i),
            "x": _ffi.from_buffer(x), "stype": _LOWER, "xtype": _REAL, "sorted": 1, "packed": 1})
        self.size: int = k.shape[0]
        order = _ffi.new("int[]", self.size)  # the better of METIS's and CHOLMOD's own is taken
        self._lib.cholmod_metis(matrix, _ffi.NULL, 0, 1, order, self._common)
        self._factor = _ffi.new("cholmod_factor**",
                                self._lib.cholmod_analyze_p(matrix, order, _ffi.NULL, 0, self._common))
        self._lib.cholmod_factorize(matrix, self._factor[0], self._common)
        # A small factor is L D L^T, which a matrix that is not definite has too.
        self._lib.cholmod_change_factor(_REAL, 1, self._factor[0].is_super, 1, 1, self._factor[0], self._common)
        if self._factor[0].minor < self.size:
            raise LabError(f"a matrix of {self.size} unknowns is not positive definite: is the body held?")

    def __del__(self) -> None:
        if hasattr(self, "_factor"):
            self._lib.cholmod_free_factor(self._factor, self._common)

    @property
    def bytes(self) -> int:
        """Of L's values and rows."""
        f = self._factor[0]
        return int(8 * f.xsize + 4 * f.ssize if f.is_super else 12 * f.nzmax)

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """K^-1 b; b: [n] or [n, k]."""
        columns = np.asfortranarray(b.reshape(self.size, -1), np.float64)
        right = _ffi.new("cholmod_dense*",
                         {"nrow": self.size, "ncol": columns.shape[1], "nzmax": columns.size, "d": self.size,
                                            "x": _ffi.cast("void*", columns.ctypes.data), "xtype": _REAL})
        solved = _ffi.new("cholmod_dense**", self._lib.cholmod_solve(_SOLVE, self._factor[0], right, self._common))
        x = np.frombuffer(_ffi.buffer(solved[0].x, 8 * columns.size)).reshape(columns.shape, order="F").copy()
        self._lib.cholmod_free_dense(solved, self._common)
        return x.reshape(b.shape)


def one_thread() -> None:
    """From here on the BLAS of this process computes in one."""
    if name := find_library("openblas"):
        _ffi.dlopen(name).openblas_set_num_threads(1)
