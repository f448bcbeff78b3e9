// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/interrupt.hpp"

#include <csignal>

namespace haptable {

namespace {

volatile std::sig_atomic_t g_interrupted = 0;

void on_signal(int signal) {
    g_interrupted = 1;
    std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

bool interrupted() noexcept { return g_interrupted != 0; }

void stop_if_interrupted() {
    if (interrupted()) throw Interrupted();
}

}  // namespace haptable
