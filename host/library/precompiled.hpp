// SPDX-License-Identifier: GPL-2.0-or-later
// The same for what is linked into the shared library too, which is compiled with other flags (packaging/install.mk).
#include "host/precompiled.hpp"
