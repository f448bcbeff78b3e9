// SPDX-License-Identifier: GPL-2.0-or-later
// Chromium without a window, over the DevTools protocol on a pipe: https://chromedevtools.github.io/devtools-protocol
#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace haptable::test {

/// A browser with one page, ended with this object. What goes wrong in it is thrown as std::runtime_error.
class Browser {
public:
    /// Why there is none here; empty where there is one.
    static std::string missing();

    /// More words of its command line, as "--disable-3d-apis"; width and height of the page, CSS pixels.
    explicit Browser(const std::vector<std::string>& words = {}, int width = 1280, int height = 800);
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    /// Opens a file or URL and waits until it is loaded.
    void open(const std::string& url);
    /// The value of an expression, awaited where it is a promise.
    nlohmann::json evaluate(const std::string& expression);
    /// Evaluates until it is true. False after `patience_s`.
    bool wait_until(const std::string& expression, double patience_s = 120.0);
    /// One command of the protocol in the page, and its result.
    nlohmann::json command(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());
    /// A pointer event: "mousePressed", "mouseMoved", "mouseReleased", "mouseWheel".
    void mouse(const std::string& type, double x, double y, double wheel = 0.0);
    /// Fingers on the screen, by place: "touchStart", "touchMove", "touchEnd".
    void touch(const std::string& type, const std::vector<std::array<double, 2>>& fingers);
    /// A page of this size, CSS pixels; a phone's has a touch screen.
    void resize(int width, int height, bool phone = false);
    /// A key of one letter, or one that has a name, as "Tab".
    void key(const std::string& letter);
    /// The page as a PNG's bytes.
    std::string screenshot();

    const std::vector<std::string>& complaints() const { return complaints_; }  ///< errors, and warnings of the console
    const std::vector<std::string>& requests() const { return requests_; }      ///< URLs, but blob: and data:

private:
    nlohmann::json call(const std::string& method, const nlohmann::json& parameters, bool in_page);
    nlohmann::json receive();
    void note(const nlohmann::json& event);

    TemporaryFolder profile_;
    int process_ = 0, to_ = -1, from_ = -1;
    int next_id_ = 0;
    std::string session_, received_;
    std::size_t scanned_ = 0;
    bool loaded_ = false, pressed_ = false;
    std::vector<std::string> complaints_, requests_;
};

/// RFC 4648, section 4; what is not of its alphabet is passed over.
std::string from_base64(std::string_view text);

}  // namespace haptable::test
