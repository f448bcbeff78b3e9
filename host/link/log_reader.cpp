// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/log_reader.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "host/base/error.hpp"
#include "host/link/udp_receiver.hpp"

namespace haptable {

namespace {

// An event: sync, number (8), time (8), length of the channel's name (4), of the data (4), name, data; the highest byte
// first.
constexpr std::array<std::uint8_t, 4> kSync{0xED, 0xA1, 0xDA, 0x01};
constexpr std::size_t kEventHeader_bytes = 28;

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t count) {
    std::uint64_t number = 0;
    for (const std::uint8_t byte : bytes.subspan(at, count)) number = number << 8 | byte;
    return number;
}

}  // namespace

LogReader::LogReader(const std::filesystem::path& file) {
    const auto fail = [&file](const std::string& why) { throw Error(file.string() + ": " + why); };
    const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (fd < 0 || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        if (fd >= 0) close(fd);
        fail("cannot be read: is the path right?");
    }
    const auto size = static_cast<std::size_t>(status.st_size);
    void* map = size == 0 ? nullptr : mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
    close(fd);
    if (map == MAP_FAILED) fail(std::string("cannot be read: ") + std::strerror(errno));
    bytes_ = {static_cast<const std::uint8_t*>(map), size};
    if (size >= kSync.size() && std::equal(kSync.begin(), kSync.end(), bytes_.begin())) return;
    if (map != nullptr) munmap(map, size);
    fail("is not an LCM log: give a file that lcm-logger wrote");
}

LogReader::~LogReader() { munmap(const_cast<std::uint8_t*>(bytes_.data()), bytes_.size()); }

std::optional<LogReader::Event> LogReader::event_at(std::size_t at) const {
    if (bytes_.size() - at < kEventHeader_bytes) return std::nullopt;
    const std::size_t channel = number_at(bytes_, at + 20, 4), data = number_at(bytes_, at + 24, 4);
    const std::size_t left = bytes_.size() - at - kEventHeader_bytes;
    if (channel == 0 || channel > kLongestChannel || channel + data > left) return std::nullopt;
    const std::size_t begin = at + kEventHeader_bytes;
    return Event{static_cast<std::int64_t>(number_at(bytes_, at + 4, 8)),
                 static_cast<std::int64_t>(number_at(bytes_, at + 12, 8)),
                 {reinterpret_cast<const char*>(bytes_.data()) + begin, channel},
                 bytes_.subspan(begin + channel, data)};
}

std::optional<LogReader::Event> LogReader::next() {
    while (at_ < bytes_.size()) {
        const auto found =
            std::search(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), bytes_.end(), kSync.begin(), kSync.end());
        at_ = static_cast<std::size_t>(found - bytes_.begin());
        const std::optional<Event> event = at_ < bytes_.size() ? event_at(at_) : std::nullopt;
        if (!event && at_ < bytes_.size()) {
            ++at_;  // a false beginning may hide a true one
            continue;
        }
        if (at_ != end_of_last_) ++damaged_;
        if (!event) break;
        at_ += kEventHeader_bytes + event->channel.size() + event->data.size();
        end_of_last_ = at_;
        return event;
    }
    return std::nullopt;
}

}  // namespace haptable
