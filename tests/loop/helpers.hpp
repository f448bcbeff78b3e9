// SPDX-License-Identifier: GPL-2.0-or-later
// What the tests of link, servo, device and loop share: a work folder, a soft box to touch, a CSV reader.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/session/scene.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

/// A new folder, with the short cuts that these tests want.
class WorkFolder : public TemporaryFolder {
public:
    std::filesystem::path operator/(const std::string& name) const { return path() / name; }
    std::size_t file_count() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path()), std::filesystem::directory_iterator()));
    }
};

/// A soft box of the paper's size, its bottom rigid; its mesh nodes are numbered otherwise than its vertices.
class SoftBox {
public:
    static constexpr std::uint64_t kHash = 1;

    SoftBox() : model_(box_shape(4, Eigen::Vector3d(0.03, 0.03, 0.03)), 0.001) {
        for (const std::int32_t node : model_.servo().node) node_.push_back(static_cast<std::uint32_t>(node));
        tables_.hash = kHash;
    }
    ServoScene scene() const { return {&tables_, node_.data(), "box"}; }
    const TestModel& model() const { return model_; }

private:
    TestModel model_;
    haptable_model tables_ = *model_.get();
    std::vector<std::uint32_t> node_;
};

/// An LCM URL on a port of this process's own: another run on this machine does not hear it.
inline std::string own_url() { return "udpm://239.255.72.84:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0"; }

/// Why LCM does not work there, for the want of a multicast route; nothing where it does.
inline std::string why_no_lcm(const std::string& url) {
    try {
        const Connection connection(url);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

/// The session of the device that asks in tests.
inline constexpr std::int64_t kSession = 0x5E5510;

/// A state of it, the finger at the origin.
inline device_state simulated_state(std::int64_t seq, std::int64_t utime) {
    device_state state{};
    state.session = kSession;
    state.mode = device_state::SIMULATED;
    state.seq = seq;
    state.utime = utime;
    return state;
}

/// The lines of a text, without their ends.
inline std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// The numbers of a CSV file's row, by its header's names.
using Row = std::map<std::string, double>;
inline std::vector<Row> read_rows(const std::filesystem::path& file) {
    std::vector<Row> rows;
    const std::vector<std::string> lines = lines_of(read_file(file));
    for (std::size_t i = 1; i < lines.size(); ++i) {
        std::istringstream names(lines[0]), cells(lines[i]);
        rows.emplace_back();
        for (std::string name, cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');)
            rows.back()[name] = std::stod(cell);
    }
    return rows;
}
/// force_x, force_y, force_z of "force_", in their order.
inline Eigen::Vector3d xyz_of(const Row& row, const std::string& name = "") {
    return {row.at(name + "x"), row.at(name + "y"), row.at(name + "z")};
}

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
}

/// Handles every message that is there already.
inline void handle_all(Connection& connection) {
    while (connection.handle_until(Clock::now())) {
    }
}

}  // namespace haptable::test
