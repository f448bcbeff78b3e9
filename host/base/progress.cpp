// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/base/interrupt.hpp"

namespace haptable {

namespace {

constexpr int kBarCells = 30;
constexpr std::chrono::milliseconds kSilentStart{1000};
constexpr std::chrono::milliseconds kRedraw{100};

}  // namespace

Progress::Progress(bool quiet)
    : on_(!quiet && isatty(STDERR_FILENO) == 1), begin_(Clock::now()), stage_begin_(begin_), last_(begin_) {}

Progress::~Progress() { clear(); }

void Progress::stage(const std::string& name) {
    stop_if_interrupted();
    name_ = name;
    stage_begin_ = Clock::now();
    if (on_ && stage_begin_ - begin_ > kSilentStart) draw(0.0, "", stage_begin_);
}

void Progress::done(double share, const std::string& detail) {
    stop_if_interrupted();
    const Clock::time_point now = Clock::now();
    if (!on_ || now - begin_ < kSilentStart || now - last_ < kRedraw) return;
    draw(std::clamp(share, 0.0, 1.0), detail, now);
}

void Progress::draw(double share, const std::string& detail, Clock::time_point now) {
    const int full = static_cast<int>(std::lround(share * kBarCells));
    std::string bar(static_cast<std::size_t>(full), '#');
    bar.resize(kBarCells, '.');
    const double elapsed = std::chrono::duration<double>(now - stage_begin_).count();
    std::fprintf(stderr, "\r\033[K%-12s [%s] %3.0f %%", name_.c_str(), bar.c_str(), 100.0 * share);
    if (share > 0.01) std::fprintf(stderr, "  %.0f s left", elapsed * (1.0 - share) / share);
    if (!detail.empty()) std::fprintf(stderr, "  %s", detail.c_str());
    std::fflush(stderr);
    last_ = now;
    drawn_ = true;
}

void Progress::clear() {
    if (drawn_) std::fprintf(stderr, "\r\033[K");
    drawn_ = false;
}

}  // namespace haptable
