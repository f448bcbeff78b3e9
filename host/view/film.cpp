// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/film.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "host/base/child.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

std::vector<std::string> command(const std::filesystem::path& path, const std::filesystem::path& out, int width,
                                 int height, double frame_ms) {
    std::vector<std::string> words{"ffmpeg",
                                   "-hide_banner",
                                   "-loglevel",
                                   "error",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pixel_format",
                                   "bgr0",
                                   "-video_size",
                                   fmt::format("{}x{}", width, height),
                                   "-framerate",
                                   fmt::format("1000000/{:.0f}", 1000.0 * frame_ms),
                                   "-i",
                                   "pipe:0"};
    const auto add = [&words](std::initializer_list<const char*> more) {
        words.insert(words.end(), more.begin(), more.end());
    };
    if (path.extension() == ".gif")
        add({"-filter_complex", "[0:v]split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse", "-f", "gif"});
    else  // this form of H.264 wants even sizes, and every player takes it
        add({"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt",
             "yuv420p", "-movflags", "+faststart", "-f", "mp4"});
    add({"-fflags", "+bitexact", "-flags:v", "+bitexact"});  // no dates and versions: same pictures, same bytes
    words.push_back("file:" + out.string());
    return words;
}

}  // namespace

bool is_film(const std::filesystem::path& path) { return path.extension() == ".mp4" || path.extension() == ".gif"; }

Film::Film(const std::filesystem::path& path, int width, int height, double frame_ms)
    : path_(path), beside_(path), complaints_(std::tmpfile(), std::fclose) {
    signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early is seen as a failed write
    std::array<int, 2> ends{};
    if (!complaints_ || pipe2(ends.data(), O_CLOEXEC) != 0)
        throw Error(std::string("no pipe to ffmpeg: ") + std::strerror(errno));
    pipe_ = ends[1];
    // Ctrl-C does not reach it: the film is ended well.
    const int failed = spawn(command(path, beside_.path(), width, height, frame_ms),
                             {ends[0], -1, fileno(complaints_.get())}, ffmpeg_);
    ::close(ends[0]);
    if (failed == 0) return;
    ::close(pipe_);
    if (failed == ENOENT)
        throw Error(path.string() +
                    ": a film needs ffmpeg, which is not installed: apt-get install ffmpeg, or give a folder for PNGs");
    throw Error(std::string("ffmpeg cannot be started: ") + std::strerror(failed));
}

Film::~Film() {
    if (pipe_ >= 0) ::close(pipe_);
    if (ffmpeg_ <= 0) return;
    kill(ffmpeg_, SIGKILL);
    waitpid(ffmpeg_, nullptr, 0);
}

void Film::add(const Image& image) {
    const char* bytes = reinterpret_cast<const char*>(image.pixel.data());
    std::size_t left = image.pixel.size() * sizeof(image.pixel[0]);
    while (left > 0) {
        const ssize_t written = write(pipe_, bytes, left);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail();
        bytes += written;
        left -= static_cast<std::size_t>(written);
    }
}

void Film::close() {
    ::close(pipe_);
    pipe_ = -1;
    int status = 0;
    while (waitpid(ffmpeg_, &status, 0) < 0 && errno == EINTR) {
    }
    ffmpeg_ = -1;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail();
    beside_.commit();
}

void Film::fail() {
    std::array<char, 400> said{};
    std::rewind(complaints_.get());
    const std::size_t count = std::fread(said.data(), 1, said.size(), complaints_.get());
    throw Error(path_.string() + ": ffmpeg failed: " + std::string(said.data(), count) +
                "; give a folder for PNGs, or mend ffmpeg");
}

}  // namespace haptable
