// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "host/base/error.hpp"

namespace haptable {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// The number that stands alone in a file, or infinity ("max" is the kernel's word for no limit).
double read_number(const char* path) {
    std::ifstream file(path);
    double value = 0.0;
    return file >> value ? value : kUnknown;
}

double kernel_estimate() {
    std::ifstream file("/proc/meminfo");
    for (std::string key; file >> key;) {
        double kib = 0.0;
        if (key == "MemAvailable:" && file >> kib) return kib * 1024.0;
        file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    return kUnknown;
}

double left_of_group(const char* limit_file, const char* used_file) {
    const double limit = read_number(limit_file), used = read_number(used_file);
    return std::isfinite(limit) && std::isfinite(used) ? limit - used : kUnknown;
}

}  // namespace

double MemoryNeed::peak() const { return stiffness + factor + std::max({fronts, pairs, columns, solves}); }

double available_memory() {
    const double group_2 = left_of_group("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current");
    const double group_1 =
        left_of_group("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes");
    return std::min({kernel_estimate(), group_2, group_1});
}

void require_memory(const std::string& scene, const MemoryNeed& need, double node_count) {
    if (need.peak() <= need.available) return;
    // The factor of a solid body grows with the nodes to the power 4/3 (nested dissection in three dimensions).
    const double fitting = node_count * std::pow(std::max(need.available, 0.0) / need.peak(), 0.75);
    throw Error(
        fmt::format("{}: needs {:.3g} GB of memory (factor {:.3g}, inversion {:.3g}, mask {:.3g}, columns {:.3g}) and "
                    "{:.3g} GB are free: use a "
                    "mesh of about {:.0f} nodes instead of {:.0f}, a smaller touch region, or a larger machine; "
                    "haptable-precompute-mpi takes several",
                    scene, need.peak() / 1e9, need.factor / 1e9, need.fronts / 1e9, need.pairs / 1e9,
                    need.columns / 1e9, need.available / 1e9, fitting, node_count));
}

}  // namespace haptable
