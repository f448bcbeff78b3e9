// SPDX-License-Identifier: GPL-2.0-or-later
// Ctrl-C and a polite kill, seen where the work can stop cleanly.
#pragma once

#include <exception>

namespace haptable {

/// Thrown by stop_if_interrupted; run_program turns it into exit status 130.
class Interrupted : public std::exception {};

/// From now on SIGINT and SIGTERM only set a flag. A second one ends the process at once.
void catch_interrupts();

/// True once SIGINT or SIGTERM has come.
bool interrupted() noexcept;

/// Throws Interrupted once SIGINT or SIGTERM has come.
void stop_if_interrupted();

}  // namespace haptable
