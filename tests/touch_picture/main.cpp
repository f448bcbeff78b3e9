// SPDX-License-Identifier: GPL-2.0-or-later
// The page in a browser, touched by a pointer: a press, a drag, and a picture of it. `make figures` runs it.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "tests/browser.hpp"

namespace haptable::test {
namespace {

struct Options {
    std::filesystem::path page, out;
    std::string size = "1280x800";
};

void want(Browser& browser, const std::string& expression, const char* what) {
    if (!browser.wait_until(expression, 120.0)) throw std::runtime_error(std::string("the page shows no ") + what);
}

/// Ticks of the page's servo, at a thousand a second of its time.
void wait_ticks(Browser& browser, int ticks) {
    const auto now = browser.evaluate("haptable.frame().tick").get<std::int64_t>();
    want(browser, fmt::format("haptable.frame().tick > {}", now + ticks), "time that goes on");
}

/// A drag in steps, as a hand makes them.
void drag(Browser& browser, double x, double y, double dx, double dy) {
    constexpr int kSteps = 20;
    for (int i = 1; i <= kSteps; ++i) {
        const double share = 0.5 - 0.5 * std::cos(M_PI * i / kSteps);
        browser.mouse("mouseMoved", x + share * dx, y + share * dy);
        wait_ticks(browser, 60);
    }
}

/// Without the footer, whose rate of pictures is that of the machine that ran this.
void write_picture(const Options& o, Browser& browser) {
    browser.evaluate("document.getElementById('about').style.visibility = 'hidden'; 0");
    write_file(o.out, browser.screenshot());
}

/// A finger that is left in its dent, and the other one beside it.
void take_two(const Options& o, Browser& browser) {
    const auto press = [&](double share) {
        const auto at = browser.evaluate(fmt::format(
            "(p => p.project([p.low[0] + {0} * (p.high[0] - p.low[0]), p.centre[1], p.high[2]]))(haptable.picture())",
            share));
        const double x = at.at(0).get<double>(), y = at.at(1).get<double>();
        browser.mouse("mouseMoved", x - 20, y);
        browser.mouse("mouseMoved", x, y);
        browser.mouse("mousePressed", x, y);
        wait_ticks(browser, 1500);
        browser.key("f");
        browser.mouse("mouseReleased", x, y);
    };
    press(0.28);
    press(0.74);
    wait_ticks(browser, 500);
    want(browser, "haptable.frame().contact && haptable.frame().second.contact", "two dents");
    write_picture(o, browser);
}

void take(const Options& o) {
    int width = 0, height = 0;
    if (std::sscanf(o.size.c_str(), "%dx%d", &width, &height) != 2) throw std::runtime_error("--size: as 1280x800");
    Browser browser({}, width, height);
    browser.open("file://" + std::filesystem::absolute(o.page).string() + "?theme=light&ratio=1&smooth=on");
    browser.evaluate("haptable.ready");
    if (browser.evaluate("haptable.scene().fingers") == 2) return take_two(o, browser);
    const auto middle = browser.evaluate("haptable.picture().project(haptable.picture().centre)");
    const double x = middle.at(0).get<double>() - 90.0, y = middle.at(1).get<double>() - 40.0;
    browser.mouse("mouseMoved", x - 20, y);
    browser.mouse("mouseMoved", x, y);
    browser.mouse("mousePressed", x, y);
    want(browser, "haptable.frame().contact", "contact");
    drag(browser, x, y, 130, 50);
    browser.mouse("mouseReleased", x + 130, y + 50);
    wait_ticks(browser, 300);
    browser.mouse("mousePressed", x + 130, y + 50);
    wait_ticks(browser, 700);
    for (int notch = 0; notch < 4; ++notch) browser.mouse("mouseWheel", x + 130, y + 50, -100);
    wait_ticks(browser, 900);
    want(browser, "haptable.frame().contact && haptable.frame().displacement.some(u => u < -1e-3)", "dent");
    write_picture(o, browser);
}

}  // namespace
}  // namespace haptable::test

int main(int argc, char** argv) {
    haptable::CommandLine app("Touches a page in Chromium by a pointer, and takes its picture.", "touch-picture");
    haptable::test::Options options;
    app.option("PAGE", options.page, "that haptable-view --page wrote").required();
    app.option("-o,--out", options.out, "a PNG").required();
    app.option("--size", options.size, "of the page, CSS pixels").show_default();
    return haptable::run_program(app, argc, argv, [&] { haptable::test::take(options); });
}
