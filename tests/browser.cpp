// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <map>
#include <stdexcept>
#include <thread>

#include "host/base/json.hpp"

namespace haptable::test {

namespace {

using nlohmann::json;

constexpr const char* kProgram = "/usr/bin/chromium";
constexpr int kPatience_ms = 120000;    // for one answer
constexpr int kReads = 3, kWrites = 4;  // the descriptors of --remote-debugging-pipe

/// Both ends of a pipe, which no other program inherits.
std::array<int, 2> make_pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    for (int& end : ends) {  // out of the way of what the browser wants there
        const int high = fcntl(end, F_DUPFD_CLOEXEC, 20);
        close(end);
        end = high;
    }
    return ends;
}

int start(const std::vector<std::string>& command, int reads, int writes) {
    std::vector<char*> argv;
    for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, reads, kReads);
    posix_spawn_file_actions_adddup2(&files, writes, kWrites);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    pid_t process = 0;
    const int failed = posix_spawn(&process, kProgram, &files, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed != 0) throw std::runtime_error("cannot start chromium");
    return process;
}

}  // namespace

std::string Browser::missing() {
    return access(kProgram, X_OK) == 0 ? "" : "no chromium: sh scripts/setup.sh test installs it";
}

Browser::Browser(const std::vector<std::string>& words, int width, int height) {
    const std::array<int, 2> in = make_pipe(), out = make_pipe();
    std::vector<std::string> command{kProgram,
                                     "--headless=new",
                                     "--remote-debugging-pipe",
                                     "--no-first-run",
                                     "--disable-background-networking",
                                     "--disable-component-update",
                                     "--mute-audio",
                                     "--hide-scrollbars",
                                     "--disable-dev-shm-usage",
                                     "--use-angle=swiftshader",
                                     "--enable-unsafe-swiftshader",
                                     "--user-data-dir=" + profile_.path().string(),
                                     "--window-size=" + std::to_string(width) + "," + std::to_string(height)};
    if (getuid() == 0) command.emplace_back("--no-sandbox");  // which root has none of
    command.insert(command.end(), words.begin(), words.end());
    process_ = start(command, in[0], out[1]);
    close(in[0]);
    close(out[1]);
    to_ = in[1];
    from_ = out[0];
    const json target = call("Target.createTarget", {{"url", "about:blank"}}, false);
    const json attached =
        call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}, false);
    session_ = attached.at("sessionId").get<std::string>();
    for (const char* domain : {"Page", "Runtime", "Network", "Log"}) this->command(std::string(domain) + ".enable");
    resize(width, height);
}

Browser::~Browser() {
    if (process_ > 0) {
        ::kill(-process_, SIGKILL);
        int status = 0;
        waitpid(process_, &status, 0);
    }
    close(to_);
    close(from_);
}

void Browser::open(const std::string& url) {
    loaded_ = false;
    complaints_.clear();
    requests_.clear();
    const json opened = command("Page.navigate", {{"url", url}});
    if (opened.contains("errorText")) throw std::runtime_error(url + ": " + opened.at("errorText").get<std::string>());
    while (!loaded_) note(receive());
}

json Browser::evaluate(const std::string& expression) {
    const json answer =
        command("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
    if (answer.contains("exceptionDetails")) {
        const json& details = answer.at("exceptionDetails");
        throw std::runtime_error(details.value("/exception/description"_json_pointer, json_text(details)));
    }
    return answer.at("result").value("value", json());
}

bool Browser::wait_until(const std::string& expression, double patience_s) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
    while (evaluate("Boolean(" + expression + ")") != true) {
        if (std::chrono::steady_clock::now() > give_up) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
}

json Browser::command(const std::string& method, const json& parameters) { return call(method, parameters, true); }

void Browser::mouse(const std::string& type, double x, double y, double wheel) {
    if (type == "mousePressed") pressed_ = true;
    if (type == "mouseReleased") pressed_ = false;
    json event{{"type", type}, {"x", x}, {"y", y}, {"buttons", pressed_ ? 1 : 0}};
    if (pressed_ || type == "mouseReleased") event.update({{"button", "left"}, {"clickCount", 1}});
    if (type == "mouseWheel") event.update({{"deltaX", 0}, {"deltaY", wheel}});
    command("Input.dispatchMouseEvent", event);
}

void Browser::touch(const std::string& type, const std::vector<std::array<double, 2>>& fingers) {
    json points = json::array();
    for (const auto& at : fingers) points.push_back({{"x", at[0]}, {"y", at[1]}, {"id", points.size()}});
    command("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", points}});
}

void Browser::resize(int width, int height, bool phone) {
    command("Emulation.setDeviceMetricsOverride",
            {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", phone}});
    command("Emulation.setTouchEmulationEnabled", {{"enabled", phone}, {"maxTouchPoints", 2}});
}

void Browser::key(const std::string& letter) {
    // The browser's own moves (focus, sliders) want the number of the key.
    static const std::map<std::string, int> kNumber{{"Tab", 9}, {"ArrowLeft", 37}, {"ArrowUp", 38}, {"ArrowRight", 39}};
    const auto number = kNumber.find(letter);
    for (const char* type : {"keyDown", "keyUp"}) {
        json event{{"type", type}, {"key", letter}};
        if (number != kNumber.end())
            event.update({{"code", letter}, {"windowsVirtualKeyCode", number->second}});
        else if (type == std::string("keyDown"))
            event["text"] = letter;
        command("Input.dispatchKeyEvent", event);
    }
}

std::string Browser::screenshot() {
    return from_base64(command("Page.captureScreenshot", {{"format", "png"}}).at("data").get<std::string>());
}

json Browser::call(const std::string& method, const json& parameters, bool in_page) {
    json message{{"id", ++next_id_}, {"method", method}, {"params", parameters}};
    if (in_page) message["sessionId"] = session_;
    const std::string text = json_text(message) + '\0';
    for (std::size_t sent = 0; sent < text.size();) {
        const ssize_t now = ::write(to_, text.data() + sent, text.size() - sent);
        if (now <= 0) throw std::runtime_error("the browser is gone");
        sent += static_cast<std::size_t>(now);
    }
    for (;;) {
        json answer = receive();
        if (answer.value("id", 0) != message["id"]) {
            note(answer);
            continue;
        }
        if (answer.contains("error")) throw std::runtime_error(method + ": " + json_text(answer.at("error")));
        return answer.at("result");
    }
}

/// The next message of the browser: JSON up to a zero byte.
json Browser::receive() {
    for (;;) {
        const std::size_t end = received_.find('\0', scanned_);
        if (end != std::string::npos) {
            json message = parse_json(std::string_view(received_).substr(0, end));
            received_.erase(0, end + 1);
            scanned_ = 0;
            return message;
        }
        scanned_ = received_.size();
        pollfd waits{from_, POLLIN, 0};
        if (poll(&waits, 1, kPatience_ms) <= 0) throw std::runtime_error("the browser says nothing");
        std::array<char, 65536> piece{};
        const ssize_t got = ::read(from_, piece.data(), piece.size());
        if (got <= 0) throw std::runtime_error("the browser is gone");
        received_.append(piece.data(), static_cast<std::size_t>(got));
    }
}

void Browser::note(const json& event) {
    const std::string method = event.value("method", "");
    const json parameters = event.value("params", json::object());
    if (method == "Page.loadEventFired") loaded_ = true;
    if (method == "Runtime.exceptionThrown" || method == "Log.entryAdded") complaints_.push_back(json_text(parameters));
    if (method == "Runtime.consoleAPICalled" &&
        (parameters.at("type") == "error" || parameters.at("type") == "warning"))
        complaints_.push_back(json_text(parameters));
    if (method != "Network.requestWillBeSent") return;
    const std::string url = parameters.at("request").at("url").get<std::string>();
    if (url.rfind("blob:", 0) != 0 && url.rfind("data:", 0) != 0) requests_.push_back(url);
}

std::string from_base64(std::string_view text) {
    static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint32_t, 256> value{};
    value.fill(64);
    for (std::uint32_t d = 0; d < 64; ++d) value[static_cast<unsigned char>(kDigits[d])] = d;
    std::string bytes;
    std::uint32_t bits = 0, held = 0;
    for (const char c : text) {
        const std::uint32_t digit = value[static_cast<unsigned char>(c)];
        if (digit == 64) continue;
        bits = bits << 6 | digit;
        if ((held += 6) < 8) continue;
        held -= 8;
        bytes += static_cast<char>(bits >> held & 0xFFU);
    }
    return bytes;
}

}  // namespace haptable::test
