// SPDX-License-Identifier: GPL-2.0-or-later
// Numerical bounds by their reasons:   measured <= count x epsilon x condition x size
//
//     EXPECT_WITHIN((x - y).norm(), .count = 8, .epsilon = kFloat, .size = model.size()) << "tick " << tick;
//
// A failure prints the measured number, the bound's terms and how far over it is. With HAPTABLE_MARGINS=file the
// largest measured / bound of every assertion is appended to that file; scripts/margins.sh lists those above a third.
#pragma once

#include <gtest/gtest.h>

namespace haptable::test {

/// Unit roundoffs: the largest relative error of one rounding to nearest.
constexpr double kDouble = 0x1p-53, kFloat = 0x1p-24, kHalf = 0x1p-11;

/// The most that an error may be. Roundings of n operations that are independent and of either sign add up to
/// sqrt(n) of one (Higham and Mary 2019); `count` is that, with the few operations of each step.
struct Bound {
    double count = 1.0;        // roundings that add up
    double epsilon = kDouble;  // of one rounding; or the error of a method, where that is what is tested
    double condition = 1.0;    // by how much the problem magnifies it
    double size = 1.0;         // of what is rounded, in the unit of what is measured

    double value() const { return count * epsilon * condition * size; }
    Bound times(double more) const { return {count, epsilon, condition * more, size}; }
};

/// A place in a test that compares; what EXPECT_WITHIN calls.
class Within {
public:
    Within(const char* file, int line) : file_(file), line_(line) {}
    testing::AssertionResult operator()(const char* what, const char* terms, double measured, const Bound& bound) const;

private:
    const char* file_;
    int line_;
};

}  // namespace haptable::test

#define HAPTABLE_WITHIN(LEVEL, measured, ...)                                                         \
    LEVEL##_PRED_FORMAT2((haptable::test::Within{__FILE__, __LINE__}), static_cast<double>(measured), \
                         (haptable::test::Bound{__VA_ARGS__}))
/// measured: an error, from 0; or what lies beyond an exact limit, then below 0 where it is kept.
#define EXPECT_WITHIN(measured, ...) HAPTABLE_WITHIN(EXPECT, measured, __VA_ARGS__)
#define ASSERT_WITHIN(measured, ...) HAPTABLE_WITHIN(ASSERT, measured, __VA_ARGS__)
