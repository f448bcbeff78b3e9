// SPDX-License-Identifier: GPL-2.0-or-later
// The same for the tests (host/precompiled.hpp).
#include <gtest/gtest.h>

#include <random>

#include "host/precompiled.hpp"
