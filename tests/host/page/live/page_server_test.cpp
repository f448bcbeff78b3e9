// SPDX-License-Identifier: GPL-2.0-or-later
// Who connects and says nothing takes no descriptor that a session needs.
#include "host/page/live/page_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace haptable::test {
namespace {

constexpr std::size_t kIdle = 2000;
constexpr rlim_t kServersDescriptors = 256;  // as few as a system may give

/// "http://127.0.0.1:PORT/..."
sockaddr_in address_of(const std::string& url) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1))));
    inet_pton(AF_INET, "127.0.0.1", &at.sin_addr);
    return at;
}

int connect_to(const sockaddr_in& at) {
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd >= 0) connect(fd, reinterpret_cast<const sockaddr*>(&at), sizeof at);
    return fd;
}

/// A process that holds kIdle connections open and says nothing, until it is told to end.
class IdleOnes {
public:
    explicit IdleOnes(const sockaddr_in& at) {
        if (pipe(ready_) != 0 || pipe(end_) != 0) return;
        id_ = fork();
        if (id_ != 0) return;
        rlimit limit{};
        getrlimit(RLIMIT_NOFILE, &limit);
        limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, kIdle + 64);
        setrlimit(RLIMIT_NOFILE, &limit);
        std::size_t made = 0;
        for (std::size_t i = 0; i < kIdle; ++i) made += connect_to(at) >= 0 ? 1 : 0;
        [[maybe_unused]] const ssize_t told = write(ready_[1], &made, sizeof made);
        close(end_[1]);
        char byte = 0;
        [[maybe_unused]] const ssize_t over = read(end_[0], &byte, 1);
        _exit(0);
    }
    ~IdleOnes() { finish(); }
    IdleOnes(const IdleOnes&) = delete;
    IdleOnes& operator=(const IdleOnes&) = delete;

    bool is_ready() const {
        pollfd from{ready_[0], POLLIN, 0};
        return poll(&from, 1, 0) > 0;
    }
    std::size_t made() const {
        std::size_t count = 0;
        return read(ready_[0], &count, sizeof count) == sizeof count ? count : 0;
    }
    void finish() {
        if (id_ <= 0) return;
        for (const int fd : {ready_[0], ready_[1], end_[0], end_[1]}) close(fd);
        waitpid(id_, nullptr, 0);
        id_ = 0;
    }

private:
    int ready_[2]{}, end_[2]{};
    pid_t id_ = 0;
};

/// What GET of the path is answered by; empty where it is not within so many rounds of the server.
std::string get(PageServer& server, int rounds) {
    const std::string url = server.url();
    const std::string host = url.substr(7, url.find('/', 7) - 7), path = url.substr(url.find('/', 7));
    const int fd = connect_to(address_of("http://" + host));
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
    std::string answer;
    bool asked = false;
    for (int i = 0; i < rounds && answer.find("</html>") == std::string::npos; ++i) {
        server.serve();
        if (!asked) asked = write(fd, request.data(), request.size()) == static_cast<ssize_t>(request.size());
        std::array<char, 4096> some{};
        const ssize_t got = read(fd, some.data(), some.size());
        if (got > 0) answer.append(some.data(), static_cast<std::size_t>(got));
        if (got == 0) break;
        usleep(1000);
    }
    close(fd);
    return answer;
}

/// As many descriptors as this process may have, until it is over.
class Descriptors {
public:
    explicit Descriptors(rlim_t count) {
        getrlimit(RLIMIT_NOFILE, &before_);
        rlimit limit = before_;
        limit.rlim_cur = std::min(count, before_.rlim_max);
        setrlimit(RLIMIT_NOFILE, &limit);
    }
    ~Descriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
    Descriptors(const Descriptors&) = delete;
    Descriptors& operator=(const Descriptors&) = delete;

private:
    rlimit before_{};
};

TEST(PageServer, SurvivesIdleConnections) {
    const Descriptors few(kServersDescriptors);
    PageServer server(0, {});
    server.set_page("<html>page</html>");
    EXPECT_NE(get(server, 5000).find("page</html>"), std::string::npos);
    IdleOnes idle(address_of(server.socket_url()));
    for (int i = 0; i < 10000 && !idle.is_ready(); ++i) {
        server.serve();
        usleep(1000);
    }
    ASSERT_TRUE(idle.is_ready());
    EXPECT_GT(idle.made(), kServersDescriptors);
    for (int i = 0; i < 200; ++i) {
        server.serve();
        usleep(1000);
    }
    // What else the session opens: its log, its pictures.
    const int other = open("/dev/null", O_RDONLY | O_CLOEXEC);
    EXPECT_GE(other, 0) << "no descriptor is left";
    close(other);
    idle.finish();
    EXPECT_NE(get(server, 20000).find("page</html>"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
