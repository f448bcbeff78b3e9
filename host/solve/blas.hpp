// SPDX-License-Identifier: GPL-2.0-or-later
// The few BLAS and LAPACK routines that the inversion and the pruned solves are made of, in double and in float under
// one name. Column-major; a matrix is its first entry and the distance between its columns.
#pragma once

namespace haptable::blas {

extern "C" {
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*, const int*,
            const double*, const int*, const double*, double*, const int*);
void sgemm_(const char*, const char*, const int*, const int*, const int*, const float*, const float*, const int*,
            const float*, const int*, const float*, float*, const int*);
void dsymm_(const char*, const char*, const int*, const int*, const double*, const double*, const int*, const double*,
            const int*, const double*, double*, const int*);
void ssymm_(const char*, const char*, const int*, const int*, const float*, const float*, const int*, const float*,
            const int*, const float*, float*, const int*);
void dtrsm_(const char*, const char*, const char*, const char*, const int*, const int*, const double*, const double*,
            const int*, double*, const int*);
void strsm_(const char*, const char*, const char*, const char*, const int*, const int*, const float*, const float*,
            const int*, float*, const int*);
void dtrsv_(const char*, const char*, const char*, const int*, const double*, const int*, double*, const int*);
void strsv_(const char*, const char*, const char*, const int*, const float*, const int*, float*, const int*);
void dgemv_(const char*, const int*, const int*, const double*, const double*, const int*, const double*, const int*,
            const double*, double*, const int*);
void sgemv_(const char*, const int*, const int*, const float*, const float*, const int*, const float*, const int*,
            const float*, float*, const int*);
void dpotrf_(const char*, const int*, double*, const int*, int*);
void dpotri_(const char*, const int*, double*, const int*, int*);
void spotri_(const char*, const int*, float*, const int*, int*);
}

/// C = alpha op(A) op(B) + beta C,   C [m,n], op(A) [m,k]; op is 'N' (as it is) or 'T' (transposed).
inline void gemm(char op_a, char op_b, int m, int n, int k, double alpha, const double* a, int lda, const double* b,
                 int ldb, double beta, double* c, int ldc) {
    dgemm_(&op_a, &op_b, &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}
inline void gemm(char op_a, char op_b, int m, int n, int k, float alpha, const float* a, int lda, const float* b,
                 int ldb, float beta, float* c, int ldc) {
    sgemm_(&op_a, &op_b, &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}

/// C = alpha A B,   A [m,m] symmetric, its lower triangle is read; B and C [m,n].
inline void symm_lower(int m, int n, double alpha, const double* a, int lda, const double* b, int ldb, double* c,
                       int ldc) {
    const double beta = 0.0;
    dsymm_("L", "L", &m, &n, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}
inline void symm_lower(int m, int n, float alpha, const float* a, int lda, const float* b, int ldb, float* c, int ldc) {
    const float beta = 0.0F;
    ssymm_("L", "L", &m, &n, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}

/// B = op(A)^-1 B (side 'L') or B = B op(A)^-1 (side 'R'),   A lower triangular, B [m,n].
inline void trsm_lower(char side, char op, int m, int n, const double* a, int lda, double* b, int ldb) {
    const double one = 1.0;
    dtrsm_(&side, "L", &op, "N", &m, &n, &one, a, &lda, b, &ldb);
}
inline void trsm_lower(char side, char op, int m, int n, const float* a, int lda, float* b, int ldb) {
    const float one = 1.0F;
    strsm_(&side, "L", &op, "N", &m, &n, &one, a, &lda, b, &ldb);
}

/// y = alpha op(A) x + beta y,   A [m,n].
inline void gemv(char op, int m, int n, double alpha, const double* a, int lda, const double* x, double beta,
                 double* y) {
    const int one = 1;
    dgemv_(&op, &m, &n, &alpha, a, &lda, x, &one, &beta, y, &one);
}
inline void gemv(char op, int m, int n, float alpha, const float* a, int lda, const float* x, float beta, float* y) {
    const int one = 1;
    sgemv_(&op, &m, &n, &alpha, a, &lda, x, &one, &beta, y, &one);
}

/// x = op(A)^-1 x,   A [n,n] lower triangular.
inline void trsv_lower(char op, int n, const double* a, int lda, double* x) {
    const int one = 1;
    dtrsv_("L", &op, "N", &n, a, &lda, x, &one);
}
inline void trsv_lower(char op, int n, const float* a, int lda, float* x) {
    const int one = 1;
    strsv_("L", &op, "N", &n, a, &lda, x, &one);
}

/// The lower triangle of A = its Cholesky factor, A [n,n]. Returns 0, or k where the k-th pivot is not positive.
inline int potrf_lower(int n, double* a, int lda) {
    int info = 0;
    dpotrf_("L", &n, a, &lda, &info);
    return info;
}

/// The lower triangle of A = (A A^T)^-1, where A comes as a lower triangular factor [n,n]. Returns 0, or k where the
/// k-th entry of its diagonal is zero.
inline int potri_lower(int n, double* a, int lda) {
    int info = 0;
    dpotri_("L", &n, a, &lda, &info);
    return info;
}
inline int potri_lower(int n, float* a, int lda) {
    int info = 0;
    spotri_("L", &n, a, &lda, &info);
    return info;
}

}  // namespace haptable::blas
