// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/udp_receiver.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"
#include "host/base/text.hpp"
#include "host/link/clock.hpp"

namespace haptable {

namespace {

// A small LCM packet: magic, the sender's count, the channel's name with a zero byte, the message.
constexpr std::uint32_t kMagic = 0x4c433032;  // "LC02"
constexpr std::size_t kHeader_bytes = 8;
constexpr std::size_t kLargestPacket_bytes = 65536;

// A socket's filter sees the UDP header first.
constexpr std::uint32_t kUdpHeader_bytes = 8;
constexpr std::uint32_t kAncillary = static_cast<std::uint32_t>(SKF_AD_OFF);

[[noreturn]] void fail_receiving(const std::string& what) {
    throw Error("LCM cannot receive: " + what + std::strerror(errno));
}

template <typename Number>
Number number_of(std::string_view text, const std::string& url) {
    Number number{};
    if (!read_number(text, number) || number < 0)
        throw Error(url + ": \"" + std::string(text) + "\" is not a number that fits there");
    return number;
}

/// The value of `key` in key=value&key=value, or nothing.
std::optional<std::string_view> argument(std::string_view arguments, std::string_view key) {
    while (!arguments.empty()) {
        const std::string_view one = arguments.substr(0, arguments.find('&'));
        arguments.remove_prefix(std::min(one.size() + 1, arguments.size()));
        const std::size_t equals = one.find('=');
        if (equals != std::string_view::npos && one.substr(0, equals) == key) return one.substr(equals + 1);
    }
    return std::nullopt;
}

/// A classic BPF program (man 7 packet, linux/filter.h) under construction. A load beyond the packet drops it.
class Filter {
public:
    void load(std::uint32_t offset) { add(BPF_LD | BPF_W | BPF_ABS, offset); }
    void load_byte(std::uint32_t offset) { add(BPF_LD | BPF_B | BPF_ABS, offset); }
    /// Skips as many instructions where the value is equal, and where it is not.
    void compare(std::uint32_t value, std::size_t equal, std::size_t other) {
        program_.push_back(
            {BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint8_t>(equal), static_cast<std::uint8_t>(other), value});
    }
    void take() { add(BPF_RET | BPF_K, 0xFFFFFFFFU); }
    void drop() { add(BPF_RET | BPF_K, 0); }
    /// Takes a packet whose bytes from `offset` on are these; goes on where they are not.
    void take_where(std::uint32_t offset, std::string_view bytes) {
        const std::size_t words = bytes.size() / 4, rest = bytes.size() % 4;
        std::size_t left = 2 * (words + rest) + 1;  // instructions to what follows
        const auto step = [&](bool word, std::uint32_t value) {
            word ? load(offset) : load_byte(offset);
            left -= 2;
            compare(value, 0, left);
            offset += word ? 4 : 1;
        };
        for (std::size_t w = 0; w < words; ++w) {
            std::uint32_t value = 0;
            for (std::size_t b = 0; b < 4; ++b) value = value << 8 | static_cast<std::uint8_t>(bytes[4 * w + b]);
            step(true, value);
        }
        for (std::size_t b = 4 * words; b < bytes.size(); ++b) step(false, static_cast<std::uint8_t>(bytes[b]));
        take();
    }
    void attach_to(int fd) {
        const sock_fprog all{static_cast<unsigned short>(program_.size()), program_.data()};
        if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &all, sizeof all) != 0) fail_receiving("its filter: ");
    }

private:
    void add(int code, std::uint32_t value) { program_.push_back({static_cast<std::uint16_t>(code), 0, 0, value}); }

    std::vector<sock_filter> program_;
};

void set(int fd, int level, int option, int value, const char* what) {
    if (setsockopt(fd, level, option, &value, sizeof value) != 0) fail_receiving(what);
}

std::int64_t time_of(msghdr& message) {
    for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMP) continue;
        timeval at{};
        std::memcpy(&at, CMSG_DATA(part), sizeof at);
        return std::int64_t{at.tv_sec} * 1'000'000 + at.tv_usec;
    }
    return utime_now();
}

}  // namespace

std::optional<MulticastUrl> parse_multicast_url(const std::string& url) {
    constexpr std::string_view kBegin = "udpm://";
    std::string_view rest = url;
    if (rest.substr(0, kBegin.size()) != kBegin) return std::nullopt;
    rest.remove_prefix(kBegin.size());
    const std::string_view place = rest.substr(0, rest.find('?'));
    const std::string_view arguments = rest.substr(std::min(place.size() + 1, rest.size()));
    MulticastUrl parsed{};
    const std::string group(place.substr(0, place.find(':')));
    if (inet_pton(AF_INET, group.empty() ? "239.255.76.67" : group.c_str(), &parsed.group) != 1 ||
        !IN_MULTICAST(ntohl(parsed.group.s_addr)))
        throw Error(url + ": \"" + group + "\" is not a multicast group: 224.0.0.0 to 239.255.255.255");
    if (place.find(':') != std::string_view::npos)
        parsed.port = number_of<std::uint16_t>(place.substr(place.find(':') + 1), url);
    if (const auto ttl = argument(arguments, "ttl")) parsed.ttl = number_of<int>(*ttl, url);
    if (const auto bytes = argument(arguments, "recv_buf_size")) parsed.receive_bytes = number_of<int>(*bytes, url);
    return parsed;
}

UdpReceiver::UdpReceiver(const MulticastUrl& url, Senders senders)
    : senders_(senders),
      fd_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
      buffer_(kLargestPacket_bytes) {
    if (fd_ < 0) fail_receiving("no socket: ");
    try {
        filter();                                                 // before it is bound: no packet comes past it
        set(fd_, SOL_SOCKET, SO_REUSEADDR, 1, "SO_REUSEADDR: ");  // servo, device, viewer and logger share the port
        set(fd_, SOL_SOCKET, SO_RCVBUF, url.receive_bytes, "recv_buf_size: ");
        set(fd_, SOL_SOCKET, SO_TIMESTAMP, 1, "SO_TIMESTAMP: ");
        set(fd_, IPPROTO_IP, IP_MULTICAST_ALL, 0, "IP_MULTICAST_ALL: ");  // not the groups that others have joined
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr = url.group;  // what is sent to the machine's own address does not come here
        at.sin_port = htons(url.port);
        if (bind(fd_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0)
            fail_receiving("port " + std::to_string(url.port) + ": ");
        const ip_mreq group{url.group, {INADDR_ANY}};
        if (setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
            fail_receiving("no multicast route: ");
    } catch (...) {
        close(fd_);
        throw;
    }
}

UdpReceiver::~UdpReceiver() { close(fd_); }

void UdpReceiver::add_channel(const std::string& channel) {
    if (channel.empty() || channel.size() > kLongestChannel)
        throw Error("\"" + channel + "\" is no channel of LCM: 1 to 63 characters");
    channel_.push_back(channel);
    filter();
}

void UdpReceiver::filter() {
    Filter f;
    if (senders_ == Senders::this_machine) {
        // Over the loopback device, or what this machine sent and the kernel gives back to it.
        f.load(kAncillary + SKF_AD_IFINDEX);
        f.compare(if_nametoindex("lo"), 3, 0);
        f.load(kAncillary + SKF_AD_PKTTYPE);
        f.compare(PACKET_LOOPBACK, 1, 0);
        f.drop();
    }
    f.load(kUdpHeader_bytes);
    f.compare(kMagic, 1, 0);
    f.drop();
    // Every message is longer than the longest name, so that no load but a damaged packet's goes beyond it.
    for (const std::string& channel : channel_)
        f.take_where(kUdpHeader_bytes + kHeader_bytes, std::string_view(channel.c_str(), channel.size() + 1));
    f.drop();
    f.attach_to(fd_);
}

std::optional<UdpReceiver::Packet> UdpReceiver::take() {
    iovec part{buffer_.data(), buffer_.size()};
    alignas(cmsghdr) std::array<char, 128> control{};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t got = recvmsg(fd_, &message, 0);
    // An error here is one of the network's, or nothing waits: neither ends a session.
    if (got < static_cast<ssize_t>(kHeader_bytes)) return std::nullopt;
    const std::size_t size = static_cast<std::size_t>(got) - kHeader_bytes;
    const auto* name = reinterpret_cast<const char*>(buffer_.data()) + kHeader_bytes;
    // The kernel's filter has seen to it; that a name ends within its packet is not left to another's word.
    const std::size_t length = strnlen(name, std::min(size, kLongestChannel + 1));
    if (length == size || length > kLongestChannel) return std::nullopt;
    const std::size_t begin = kHeader_bytes + length + 1;
    return Packet{{name, length}, buffer_.data() + begin, static_cast<std::size_t>(got) - begin, time_of(message)};
}

}  // namespace haptable
