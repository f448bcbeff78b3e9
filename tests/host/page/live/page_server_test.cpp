// SPDX-License-Identifier: GPL-2.0-or-later
// Who connects and says nothing takes no descriptor that a session needs.
#include "host/page/live/page_server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

constexpr int kIdle = 2000;
constexpr rlim_t kServersDescriptors = 256;  // as few as a system may give

/// Connects to the port as often as it is told, says nothing, and tells how many were made.
constexpr const char* kIdleOnes =
    "import resource, socket, sys, time\n"
    "port, count = int(sys.argv[1]), int(sys.argv[2])\n"
    "resource.setrlimit(resource.RLIMIT_NOFILE, (min(count + 64, resource.getrlimit(resource.RLIMIT_NOFILE)[1]),) * "
    "2)\n"
    "idle = [socket.socket() for _ in range(count)]\n"
    "for one in idle:\n"
    "    one.setblocking(False)\n"
    "    one.connect_ex(('127.0.0.1', port))\n"
    "print(len(idle), flush=True)\n"
    "time.sleep(600)\n";

/// What GET of its page is answered by; empty where it is not within so many rounds of the server.
std::string get(PageServer& server, int rounds) {
    const TemporaryFolder folder;
    const std::string out = folder.path() / "out",
                      code =
                          "import sys, urllib.request as r\n"
                          "print(r.build_opener(r.ProxyHandler({})).open(sys.argv[1]).read().decode())";
    const Process client({"/usr/bin/python3", "-c", code, server.url()}, Process::Place{{}, out, {}});
    std::string answer;
    for (int i = 0; i < rounds && answer.find("</html>") == std::string::npos; ++i, usleep(1000)) {
        server.serve();
        if (std::filesystem::exists(out)) answer = read_file(out);
    }
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
    EXPECT_TRUE(says(get(server, 5000), "page</html>"));
    const std::string url = server.socket_url(), port = url.substr(url.rfind(':') + 1);
    const TemporaryFolder folder;
    const std::string made = folder.path() / "made";
    std::optional<Process> idle(std::in_place,
                                std::vector<std::string>{"/usr/bin/python3", "-c", kIdleOnes,
                                                         std::to_string(std::stoi(port)), std::to_string(kIdle)},
                                Process::Place{{}, made, {}});
    const auto serve = [&](int rounds) {
        for (int i = 0; i < rounds; ++i, usleep(1000)) server.serve();
    };
    for (int i = 0; i < 10000 && (!std::filesystem::exists(made) || std::filesystem::file_size(made) == 0); ++i)
        serve(1);
    EXPECT_EQ(read_file(made), std::to_string(kIdle) + "\n");
    serve(200);
    // What else the session opens: its log, its pictures.
    const int other = open("/dev/null", O_RDONLY | O_CLOEXEC);
    EXPECT_GE(other, 0) << "no descriptor is left";
    close(other);
    idle.reset();
    EXPECT_TRUE(says(get(server, 20000), "page</html>"));
}

}  // namespace
}  // namespace haptable::test
