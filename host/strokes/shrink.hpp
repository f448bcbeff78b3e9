// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "host/strokes/judge.hpp"

namespace haptable {

/// A stroke of fewer ticks that has the same fault: none of them can be left out, alone or with its neighbours, without
/// losing the fault or making the finger faster than it was (or than 5 m/s, whichever is more).
/// before: judge(touched, stroke).has(fault).
Stroke shrink(const Touched& touched, const Stroke& stroke, Fault fault);

}  // namespace haptable
