// SPDX-License-Identifier: GPL-2.0-or-later
// The receiving half of LCM over UDP multicast, guarded: what is not ours never leaves the kernel.
//
// liblcm 1.3.1 takes packets from any machine, and puts the parts of large messages together without checking where
// they lie: one packet writes outside its buffer. Here a filter in the kernel drops, before this program is woken,
//  - what another machine sent, whatever sender's address it bears (unless asked for);
//  - parts of messages: ours fit a packet;
//  - channels that nobody subscribed to.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptable {

inline constexpr std::size_t kLongestChannel = 63;  ///< characters of a name, LCM's limit

/// What stands in udpm://GROUP:PORT?ttl=T&recv_buf_size=B.
struct MulticastUrl {
    in_addr group;
    std::uint16_t port = 7667;
    int ttl = 0;
    int receive_bytes = 1 << 21;  ///< of the socket's buffer, which the kernel may keep smaller
};

/// Nothing where the URL is not udpm's. Throws Error where it is and does not name a multicast group and a port.
std::optional<MulticastUrl> parse_multicast_url(const std::string& url);

/// Whose packets are taken.
enum class Senders {
    this_machine,  ///< by the kernel's own word on where a packet came in, which nobody can forge
    any            ///< other machines' too
};

class UdpReceiver {
public:
    /// One message of a packet; valid until the next.
    struct Packet {
        std::string_view channel;
        const std::uint8_t* data;
        std::size_t size;             ///< bytes
        std::int64_t received_utime;  ///< when the kernel got it, microseconds since the epoch
    };

    /// Joins the group; nothing comes yet. Throws Error that says what to do.
    UdpReceiver(const MulticastUrl& url, Senders senders);
    ~UdpReceiver();
    UdpReceiver(const UdpReceiver&) = delete;
    UdpReceiver& operator=(const UdpReceiver&) = delete;

    /// Lets the messages of one more channel in. Throws Error where a name is longer than LCM's 63 characters.
    void add_channel(const std::string& channel);
    /// For poll: readable when a message waits.
    int fd() const { return fd_; }
    /// The next message that waits, or nothing.
    std::optional<Packet> take();

private:
    void filter();

    Senders senders_;
    int fd_;
    std::vector<std::string> channel_;
    std::vector<std::uint8_t> buffer_;
};

}  // namespace haptable
