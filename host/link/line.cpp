// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/line.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "host/base/child.hpp"
#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/link/baud.hpp"

namespace haptable {

namespace {

constexpr int kWritePatience_ms = 1000;

[[noreturn]] void fail_opening(const std::string& what, const char* then = "") {
    throw Error(what + ": " + std::strerror(errno) + then);
}

struct Speed {
    unsigned baud;
    speed_t code;
};
constexpr std::array kSpeeds{Speed{9600, B9600},       Speed{19200, B19200},     Speed{38400, B38400},
                             Speed{57600, B57600},     Speed{115200, B115200},   Speed{230400, B230400},
                             Speed{460800, B460800},   Speed{500000, B500000},   Speed{576000, B576000},
                             Speed{921600, B921600},   Speed{1000000, B1000000}, Speed{1152000, B1152000},
                             Speed{1500000, B1500000}, Speed{2000000, B2000000}, Speed{2500000, B2500000},
                             Speed{3000000, B3000000}, Speed{3500000, B3500000}, Speed{4000000, B4000000}};

speed_t speed_of(unsigned baud) {
    std::string known;
    for (const Speed& speed : kSpeeds) {
        if (speed.baud == baud) return speed.code;
        known += " " + std::to_string(speed.baud);
    }
    throw BadCommandLine("--baud " + std::to_string(baud) + ": Linux knows" + known);
}

/// Raw bytes, 8N1, no flow control, whoever had the port before; without HUPCL, which resets some boards at our end.
void make_raw(int fd, const std::string& name, unsigned baud, Speeds speeds) {
    termios port{};
    const speed_t speed = speeds == Speeds::any ? B38400 : speed_of(baud);
    if (tcgetattr(fd, &port) != 0) fail_opening(name, ": is it a serial port?");
    cfmakeraw(&port);
    port.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
    port.c_cflag |= CLOCAL | CREAD;
    port.c_cc[VMIN] = port.c_cc[VTIME] = 0;
    cfsetispeed(&port, speed);
    cfsetospeed(&port, speed);
    termios got{};
    // tcsetattr is content when it could change anything: what the port took has to be asked for.
    if (tcsetattr(fd, TCSANOW, &port) != 0 || tcgetattr(fd, &got) != 0) fail_opening(name, ": is it a serial port?");
    if (cfgetospeed(&got) != speed || (got.c_cflag & (CSIZE | PARENB)) != CS8)
        throw Error(fmt::format("{}: does not take {} baud, 8N1: another --baud", name, baud));
    if (speeds == Speeds::any && !set_any_baud(fd, baud))
        throw Error(fmt::format("{}: does not take {} baud: does its driver divide freely?", name, baud));
    tcflush(fd, TCIOFLUSH);
}

/// Two programs on one port would each get some of the bytes.
void make_ours(int fd, const std::string& name) {
    if (flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        throw Error(name + ": another program has it: fuser " + name);
    ioctl(fd, TIOCEXCL);
}

int connect_socket(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) throw Error(path + ": too long for the name of a socket");
    path.copy(address.sun_path, path.size());
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0 || connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        fail_opening(path, ": does its other end listen?");
    return fd;
}

/// Both ends' flags: a pipe without a partner is open, and stays so when the partner restarts.
int open_pipe(const std::filesystem::path& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0 || !S_ISFIFO(status.st_mode))
        throw Error(path.string() + ": not a named pipe: run mkfifo " + path.string());
    const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) fail_opening(path);
    return fd;
}

void stop(pid_t child) {
    kill(child, SIGTERM);
    for (int tries = 0; tries < 200; ++tries, usleep(10'000))
        if (waitpid(child, nullptr, WNOHANG) != 0) return;
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
}

}  // namespace

Line::Line(std::string name, int in, int out, pid_t child)
    : name_(std::move(name)), in_(in), out_(out), child_(child) {}

Line::Line(Line&& other) noexcept
    : name_(std::move(other.name_)),
      in_(std::exchange(other.in_, -1)),
      out_(std::exchange(other.out_, -1)),
      child_(std::exchange(other.child_, 0)),
      is_port_(other.is_port_) {}

Line::~Line() {
    if (out_ >= 0 && out_ != in_) close(out_);
    if (in_ >= 0) close(in_);
    if (child_ > 0) stop(child_);
}

Line Line::open(const std::filesystem::path& path, unsigned baud, Speeds speeds) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) fail_opening(path, ": is the microcontroller plugged in? ls /dev/tty*");
    if (S_ISSOCK(status.st_mode)) {
        const int fd = connect_socket(path);
        return {path, fd, fd};
    }
    const int fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) fail_opening(path, ": may you open it? (group dialout)");
    Line line(path, fd, fd);
    line.is_port_ = true;
    make_ours(fd, path);
    make_raw(fd, path, baud, speeds);
    return line;
}

Line Line::pipes(const std::filesystem::path& to_target, const std::filesystem::path& from_target) {
    Line line(to_target.string() + " and " + from_target.string(), open_pipe(from_target), -1);
    line.out_ = open_pipe(to_target);
    return line;
}

Line Line::program(const std::string& command) {
    std::array<int, 2> end{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, end.data()) != 0) fail_opening("--run");
    fcntl(end[0], F_SETFL, O_NONBLOCK);
    Line line(command, end[0], end[0]);
    const int failed = spawn({"sh", "-c", "exec " + command}, {end[1], end[1], STDERR_FILENO}, line.child_);
    close(end[1]);
    errno = failed;
    if (failed != 0) fail_opening("--run " + command);
    return line;
}

std::size_t Line::read(std::span<std::uint8_t> into) {
    const ssize_t got = ::read(in_, into.data(), into.size());
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    // A tty that is idle gives 0 as well; one that was pulled out is none any more.
    if (got == 0 && isatty(in_) == 1) return 0;
    fail_closed();
}

void Line::fail_closed() const {
    if (!is_port_) throw Error(name_ + ": the other end has closed the line");
    throw Error(name_ + ": the port has gone: plug the target in again, look for its name (ls /dev/tty*), start again");
}

void Line::write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t sent = ::write(out_, bytes.data(), bytes.size());
        if (sent > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(sent));
            continue;
        }
        if (errno != EAGAIN && errno != EINTR) fail_closed();
        pollfd fd{out_, POLLOUT, 0};
        if (errno == EAGAIN && poll(&fd, 1, kWritePatience_ms) == 0)
            throw Error(name_ + ": takes no bytes for a second: does the target read them?");
    }
}

}  // namespace haptable
