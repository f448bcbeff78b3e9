// SPDX-License-Identifier: GPL-2.0-or-later
// What most files of the host include of others' headers: the compiler reads it once (Makefile, PRECOMPILED). Files
// still include what they use: without it they compile as well.
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>
