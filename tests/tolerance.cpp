// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/tolerance.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace haptable::test {

namespace {

/// The nearest that each assertion came to its bound; written when the program ends.
class Margins {
public:
    ~Margins() {
        std::FILE* file = path_ != nullptr ? std::fopen(path_, "a") : nullptr;
        if (file == nullptr) return;
        for (const auto& [place, nearest] : nearest_)
            fmt::print(file, "{:.3g} {}:{} {}\n", nearest.ratio, place.first, place.second, nearest.says);
        std::fclose(file);
    }
    bool wanted() const { return path_ != nullptr; }
    void take(const char* file, int line, double measured, const Bound& bound) {
        const double ratio = measured <= 0.0 ? 0.0 : measured / bound.value();
        const std::lock_guard lock(mutex_);
        const auto [at, fresh] = nearest_.try_emplace({file, line}, Nearest{});
        if (!fresh && ratio <= at->second.ratio) return;
        const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
        const std::string name = test == nullptr ? "" : fmt::format("{}.{}", test->test_suite_name(), test->name());
        at->second = {ratio, fmt::format("{} {:.3g} of {:.3g}", name, measured, bound.value())};
    }

private:
    struct Nearest {
        double ratio = 0.0;
        std::string says;
    };
    const char* path_ = std::getenv("HAPTABLE_MARGINS");
    std::map<std::pair<std::string_view, int>, Nearest> nearest_;
    std::mutex mutex_;
};

}  // namespace

testing::AssertionResult Within::operator()(const char* what, const char*, double measured, const Bound& bound) const {
    static Margins margins;
    if (margins.wanted()) margins.take(file_, line_, measured, bound);
    if (measured <= bound.value()) return testing::AssertionSuccess();
    return testing::AssertionFailure() << fmt::format(
               "{}\n  is {:.6g}, {:.3g} times its bound {:.6g}\n  = count {:.4g} x epsilon {:.4g} x condition {:.4g} x "
               "size {:.4g}",
               what, measured, measured / bound.value(), bound.value(), bound.count, bound.epsilon, bound.condition,
               bound.size);
}

}  // namespace haptable::test
