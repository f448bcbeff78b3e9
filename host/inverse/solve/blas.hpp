// SPDX-License-Identifier: GPL-2.0-or-later
// The few BLAS and LAPACK routines that the inversion and the pruned solves are made of, in double and in float under
// one name. Column-major; a matrix is its first entry and the distance between its columns.
#pragma once

#include <cblas.h>

#include <type_traits>

namespace haptable::blas {

// LAPACK, which no header of OpenBLAS declares with const.
extern "C" {
void dpotrf_(const char*, const int*, double*, const int*, int*);
void dpotri_(const char*, const int*, double*, const int*, int*);
void spotri_(const char*, const int*, float*, const int*, int*);
}

inline CBLAS_TRANSPOSE transposed(char op) { return op == 'T' ? CblasTrans : CblasNoTrans; }

/// The routine for numbers of type T.
template <typename T, typename Double, typename Single>
constexpr auto* pick(Double* in_double, Single* in_float) {
    if constexpr (std::is_same_v<T, double>)
        return in_double;
    else
        return in_float;
}

/// C = alpha op(A) op(B) + beta C,   C [m,n], op(A) [m,k]; op is 'N' (as it is) or 'T' (transposed).
template <typename T>
void gemm(char op_a, char op_b, int m, int n, int k, T alpha, const T* a, int lda, const T* b, int ldb, T beta, T* c,
          int ldc) {
    pick<T>(cblas_dgemm, cblas_sgemm)(CblasColMajor, transposed(op_a), transposed(op_b), m, n, k, alpha, a, lda, b, ldb,
                                      beta, c, ldc);
}

/// C = alpha A B,   A [m,m] symmetric, its lower triangle is read; B and C [m,n].
template <typename T>
void symm_lower(int m, int n, T alpha, const T* a, int lda, const T* b, int ldb, T* c, int ldc) {
    pick<T>(cblas_dsymm, cblas_ssymm)(CblasColMajor, CblasLeft, CblasLower, m, n, alpha, a, lda, b, ldb, T(0), c, ldc);
}

/// B = op(A)^-1 B (side 'L') or B = B op(A)^-1 (side 'R'),   A lower triangular, B [m,n].
template <typename T>
void trsm_lower(char side, char op, int m, int n, const T* a, int lda, T* b, int ldb) {
    pick<T>(cblas_dtrsm, cblas_strsm)(CblasColMajor, side == 'L' ? CblasLeft : CblasRight, CblasLower, transposed(op),
                                      CblasNonUnit, m, n, T(1), a, lda, b, ldb);
}

/// y = alpha op(A) x + beta y,   A [m,n].
template <typename T>
void gemv(char op, int m, int n, T alpha, const T* a, int lda, const T* x, T beta, T* y) {
    pick<T>(cblas_dgemv, cblas_sgemv)(CblasColMajor, transposed(op), m, n, alpha, a, lda, x, 1, beta, y, 1);
}

/// x = op(A)^-1 x,   A [n,n] lower triangular.
template <typename T>
void trsv_lower(char op, int n, const T* a, int lda, T* x) {
    pick<T>(cblas_dtrsv, cblas_strsv)(CblasColMajor, CblasLower, transposed(op), CblasNonUnit, n, a, lda, x, 1);
}

/// The lower triangle of A = its Cholesky factor, A [n,n]. Returns 0, or k where the k-th pivot is not positive.
inline int potrf_lower(int n, double* a, int lda) {
    int info = 0;
    dpotrf_("L", &n, a, &lda, &info);
    return info;
}

/// The lower triangle of A = (A A^T)^-1, where A comes as a lower triangular factor [n,n]. Returns 0, or k where the
/// k-th entry of its diagonal is zero.
template <typename T>
int potri_lower(int n, T* a, int lda) {
    int info = 0;
    pick<T>(dpotri_, spotri_)("L", &n, a, &lda, &info);
    return info;
}

}  // namespace haptable::blas
