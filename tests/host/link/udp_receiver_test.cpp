// SPDX-License-Identifier: GPL-2.0-or-later
// What a guarded receiver lets in: packets are sent by hand, sound and hostile, from here and from another machine.
#include "host/link/udp_receiver.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "host/base/error.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

constexpr const char* kGroup = "239.255.72.84";

std::string url_of(int port) { return fmt::format("udpm://{}:{}?ttl=0", kGroup, port); }
/// A port of our own: another run on this machine does not hear us.
int port_of(int test) { return 40000 + 8 * (getpid() % 2500) + test; }

std::string big_endian(std::uint64_t value, int bytes) {
    std::string text;
    for (int b = bytes - 1; b >= 0; --b) text += static_cast<char>(value >> (8 * b));
    return text;
}

/// A whole small message, as liblcm sends it.
std::string packet(const std::string& channel, const std::string& data) {
    return big_endian(0x4c433032, 4) + big_endian(1, 4) + channel + '\0' + data;
}

/// Part of a large one.
std::string fragment(std::uint32_t offset, std::uint16_t number, std::uint32_t size, const std::string& data) {
    return big_endian(0x4c433033, 4) + big_endian(7, 4) + big_endian(size, 4) + big_endian(offset, 4) +
           big_endian(number, 2) + big_endian(2, 2) + data;
}

class Sender {
public:
    explicit Sender(int port, int ttl = 0) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
        to_.sin_family = AF_INET;
        to_.sin_port = htons(static_cast<std::uint16_t>(port));
        inet_pton(AF_INET, kGroup, &to_.sin_addr);
    }
    ~Sender() { close(fd_); }
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;
    void send_to(const char* address, const std::string& bytes) {
        inet_pton(AF_INET, address, &to_.sin_addr);
        send(bytes);
    }
    void send(const std::string& bytes) const {
        sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
    }

private:
    int fd_;
    sockaddr_in to_{};
};

/// The data of the next packet, or nothing within the time.
std::optional<std::string> next(UdpReceiver& receiver, int wait_ms = 2000) {
    pollfd from{receiver.fd(), POLLIN, 0};
    if (poll(&from, 1, wait_ms) <= 0) return std::nullopt;
    const auto packet = receiver.take();
    if (!packet) return std::nullopt;
    return std::string(packet->channel) + ":" + std::string(reinterpret_cast<const char*>(packet->data), packet->size);
}

class UdpReceiverTest : public testing::Test {
protected:
    void SetUp() override {
        if (const std::string why = why_no_lcm(url_of(port_of(0))); !why.empty()) GTEST_SKIP() << why;
    }
};

TEST_F(UdpReceiverTest, BringsWholeMessagesOfItsChannels) {
    UdpReceiver receiver(*parse_multicast_url(url_of(port_of(1))), Senders::this_machine);
    receiver.add_channel("HAPTABLE_STATE");
    receiver.add_channel("ABC");
    const Sender sender(port_of(1));
    const std::int64_t before = utime_now();
    const std::string data(60, 'd');
    for (const char* channel : {"HAPTABLE_STATE", "HAPTABLE_STATES", "HAPTABLE_STAT", "HAPTABLE", "XABC", "ABC"})
        sender.send(packet(channel, data + channel));
    std::string other_protocol = packet("ABC", std::string(60, 'o'));
    other_protocol[3] = '3';
    sender.send(other_protocol);
    sender.send(packet("HAPTABLE_STATE", ""));
    for (const std::string& wanted :
         {"HAPTABLE_STATE:" + data + "HAPTABLE_STATE", "ABC:" + data + "ABC", std::string("HAPTABLE_STATE:")})
        EXPECT_EQ(next(receiver), wanted);
    EXPECT_EQ(next(receiver, 20), std::nullopt);
    sender.send(packet("ABC", std::string(60000, 'x')));
    pollfd from{receiver.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&from, 1, 2000), 1);
    const auto large = receiver.take();
    ASSERT_TRUE(large);
    EXPECT_EQ(large->size, 60000U);
    EXPECT_GE(large->received_utime, before);
    EXPECT_LE(large->received_utime, utime_now());
}

// liblcm 1.3.1 writes this fragment outside of its buffer; the rest are the other ways to be short, or nobody's.
TEST_F(UdpReceiverTest, HostilePacketsHarmNobody) {
    const int port = port_of(2);
    Connection connection(url_of(port));
    int came = 0;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state&, std::int64_t) { ++came; });
    const Sender sender(port);
    const std::string name = std::string(channel_of<device_state>()) + '\0';
    for (const std::uint32_t offset : {0xFFFFFFFFU - 199U, 0x7FFFFFFFU, 900U}) {
        sender.send(fragment(0, 0, 1000, name + std::string(100, 'a')));
        sender.send(fragment(offset, 1, 1000, std::string(300, 'b')));
    }
    sender.send(fragment(0, 0, 0xFFFFFFFFU, name));
    const std::string whole = packet(channel_of<device_state>(), std::string(200, 'c'));
    for (std::size_t cut = 0; cut < whole.size(); ++cut) sender.send(whole.substr(0, cut));
    sender.send(packet(std::string(5000, 'n'), ""));
    connection.publish(channel_of<device_state>(), device_state{});
    const Clock::time_point give_up = Clock::now() + std::chrono::seconds(5);
    while (came == 0 && connection.handle_until(give_up)) {
    }
    EXPECT_EQ(came, 1);
    EXPECT_GT(connection.undecodable(), 0U);
}

TEST_F(UdpReceiverTest, TheMachinesOwnAddressIsNotListenedTo) {
    UdpReceiver receiver(*parse_multicast_url(url_of(port_of(3))), Senders::any);
    receiver.add_channel("ABC");
    Sender sender(port_of(3));
    sender.send_to("127.0.0.1", packet("ABC", std::string(60, 'u')));
    EXPECT_EQ(next(receiver, 50), std::nullopt);
    sender.send_to(kGroup, packet("ABC", "m"));
    EXPECT_EQ(next(receiver), "ABC:m");
}

// ---- two machines --------------------------------------------------------------------------------------------------

void write_to(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

/// A network of its own for this process. False where the machine does not let us have one.
bool enter_own_network() {
    const unsigned user = getuid(), group = getgid();
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
    write_to("/proc/self/setgroups", "deny");
    write_to("/proc/self/uid_map", fmt::format("0 {} 1", user));
    write_to("/proc/self/gid_map", fmt::format("0 {} 1", group));
    return system("ip link set lo up 2>/dev/null") == 0;
}

constexpr int kNoNetworks = 100;

/// A second machine, on a cable to this one, sends; then this machine. Which receivers heard which: a bit each.
int hear_two_machines() {
    if (!enter_own_network()) return kNoNetworks;
    int ready[2], go[2];
    if (pipe(ready) != 0 || pipe(go) != 0) return kNoNetworks;
    const int port = 7684;
    const std::string hello = packet("ABC", std::string(60, 'h'));
    const pid_t other = fork();
    if (other == 0) {
        char byte = 0;
        if (unshare(CLONE_NEWNET) != 0 || write(ready[1], "r", 1) != 1 || read(go[0], &byte, 1) != 1) _exit(1);
        if (system("ip address add 10.99.0.2/24 dev there && ip link set there up && "
                   "ip route add 224.0.0.0/4 dev there") != 0)
            _exit(1);
        Sender sender(port, 1);
        for (int tries = 0; tries < 40; ++tries) {  // a cable takes a moment
            sender.send(hello);
            sender.send_to("10.99.0.1", hello);
            sender.send_to(kGroup, hello);
            usleep(10'000);
        }
        // Its end of the cable stays as long as it lives.
        _exit(write(ready[1], "d", 1) == 1 && read(go[0], &byte, 1) == 1 ? 0 : 1);
    }
    char byte = 0;
    const auto end_other = [other](int result) {
        kill(other, SIGKILL);
        waitpid(other, nullptr, 0);
        return result;
    };
    const std::string cable = fmt::format(
        "ip link add here type veth peer name there netns {} && ip address add 10.99.0.1/24 dev here && "
        "ip link set here up && ip route add 224.0.0.0/4 dev here",
        other);
    if (read(ready[0], &byte, 1) != 1 || system(cable.c_str()) != 0) return end_other(kNoNetworks);
    const MulticastUrl url = *parse_multicast_url(url_of(port));
    UdpReceiver anyone(url, Senders::any), ours(url, Senders::this_machine);
    anyone.add_channel("ABC");
    ours.add_channel("ABC");
    int heard = write(go[1], "g", 1) == 1 && next(anyone, 5000) ? 1 : 0;
    heard |= read(ready[0], &byte, 1) == 1 && next(ours, 50) ? 2 : 0;
    for (const int ttl : {0, 1}) {  // by the kernel's loop, though the route leads out
        Sender(port, ttl).send(hello);
        heard |= next(ours, 2000) ? 4 << ttl : 0;
    }
    return end_other(heard);
}

TEST(UdpReceiver, AnotherMachineIsNotHeardUnlessAskedFor) {
    const int heard = status_of(hear_two_machines);
    if (heard == kNoNetworks) GTEST_SKIP() << "no network namespaces for this user: another machine cannot be tried";
    EXPECT_EQ(heard, 1 | 4 | 8) << "1: it was there, 2: it was heard, 4 and 8: this machine was with ttl=0 and ttl=1";
}

// ---- addresses -----------------------------------------------------------------------------------------------------

TEST(UdpReceiver, ReadsLcmsUrls) {
    const MulticastUrl all = parse_multicast_url("udpm://239.1.2.3:7000?recv_buf_size=4096&ttl=2").value();
    EXPECT_EQ(ntohl(all.group.s_addr), 0xEF010203U);
    EXPECT_EQ(all.port, 7000);
    EXPECT_EQ(all.ttl, 2);
    EXPECT_EQ(all.receive_bytes, 4096);
    const MulticastUrl shortest = parse_multicast_url("udpm://").value();
    EXPECT_EQ(shortest.port, 7667);
    EXPECT_EQ(shortest.ttl, 0);
    EXPECT_FALSE(parse_multicast_url("memq://"));
    for (const char* bad : {"udpm://10.0.0.1:7000", "udpm://nonsense", "udpm://239.1.2.3:70000", "udpm://239.1.2.3:x",
                            "udpm://239.1.2.3:7000?ttl=-1", "udpm://239.1.2.3:7000?ttl="})
        EXPECT_THROW(parse_multicast_url(bad), Error) << bad;
}

}  // namespace
}  // namespace haptable::test
