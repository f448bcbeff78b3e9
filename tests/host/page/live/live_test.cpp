// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-view --serve over a real session, with browsers without a window: a page that looks, one whose pointer is
// the device, a second one that looks while it touches, and what goes wrong. Skipped where LCM has no multicast route
// (run these under scripts/loopback.sh) or the programs are not built.
#include "host/page/live/live.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <optional>
#include <set>
#include <thread>

#include "host/base/error.hpp"
#include "tests/browser.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// One browser for the tests that need one alone, which takes a second to start.
Browser& shared_browser() {
    static Browser one;
    return one;
}

class LivePage : public testing::Test {
protected:
    void SetUp() override {
        const std::string url = own_url();
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
        for (const std::filesystem::path& needed : {cube / "servo", program("haptable-device"),
                                                    program("haptable-view"), build_folder() / "lib/page/servo.wasm"})
            if (!std::filesystem::exists(needed)) GTEST_SKIP() << needed << " is not built: make test";
        if (const std::string why = Browser::missing(); !why.empty()) GTEST_SKIP() << why;
        if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }

    Process::Place place(const std::string& name) const {
        return {{}, (folder / (name + ".out")).string(), (folder / (name + ".err")).string()};
    }
    void start_servo(const std::string& csv) { start_servo(cube, csv); }
    void start_servo(const std::filesystem::path& tables, const std::string& csv) {
        servo.emplace(std::vector<std::string>{(tables / "servo").string(), "--lcm", "--no-realtime", "--quiet",
                                               "--csv", (folder / csv).string()});
    }
    void end_servo() {
        servo->kill(SIGTERM);
        EXPECT_EQ(servo->wait_for_exit(), 0);
    }
    static std::vector<std::string> device(std::vector<std::string> more,
                                           const std::string& scene = "meshes/cube.toml") {
        more.insert(more.begin(), {program("haptable-device").string(), scene, "--no-realtime", "--quiet"});
        return more;
    }
    /// Serves the tables in `tables`; the address that it prints.
    std::string serve(const std::filesystem::path& tables, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {program("haptable-view").string(), tables.string(), "--lcm", "--serve"});
        view.emplace(more, place("view"));
        const auto give_up = Clock::now() + std::chrono::seconds(60);
        while (Clock::now() < give_up) {
            const std::string said = std::filesystem::exists(folder / "view.out") ? read_file(folder / "view.out") : "";
            if (const std::size_t end = said.find('\n'); end != std::string::npos) return said.substr(0, end);
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        ADD_FAILURE() << "no address: " << read_file(folder / "view.err");
        return "";
    }
    static void open(Browser& browser, const std::string& url) {
        browser.mouse("mouseReleased", 0, 0);  // as the test before may have left it
        browser.open(url);
        ASSERT_EQ(browser.evaluate("haptable.ready.then(() => 'ready', error => error.message)"), "ready");
        ASSERT_TRUE(browser.wait_until("haptable.live().touch !== undefined")) << "it hears from its server";
    }
    static std::string link(Browser& browser) {
        return browser.evaluate("document.getElementById('link').textContent").get<std::string>();
    }
    static bool says(Browser& browser, const std::string& text) {
        return browser.wait_until("document.getElementById('link').textContent.includes('" + text + "')");
    }
    static std::array<double, 2> top(Browser& browser) {
        const auto at = browser.evaluate("haptable.picture().project([0.015, 0.015, 0.03])");
        return {at.at(0).get<double>(), at.at(1).get<double>()};
    }
    static void press(Browser& browser) {
        const auto at = top(browser);
        browser.mouse("mouseMoved", at[0] - 20, at[1]);
        browser.mouse("mouseMoved", at[0], at[1]);
        browser.mouse("mousePressed", at[0], at[1]);
    }
    /// Nothing but the page itself is asked for, and the console is empty.
    static void expect_quiet(const Browser& browser, const std::string& url) {
        EXPECT_EQ(browser.complaints(), std::vector<std::string>{});
        for (const std::string& request : browser.requests()) EXPECT_EQ(request, url);
    }

    WorkFolder folder;
    std::filesystem::path cube = build_folder() / "cube";
    std::optional<Process> servo, view;
};

/// The lines of a servo's CSV without tick and area coordinates, which the messages do not carry.
std::vector<std::string> felt(const std::string& csv) {
    std::vector<std::string> rows;
    for (const std::string& line : lines_of(csv)) {
        std::istringstream in(line);
        std::string row, cell;
        for (int column = 0; std::getline(in, cell, ','); ++column)
            if (column != 0 && (column < 8 || column > 10)) row += cell + ",";
        rows.push_back(row);
    }
    return rows;
}

/// Of a row of felt().
bool is_silent(const std::string& row) {
    constexpr int kState = 14;
    std::istringstream in(row);
    std::string cell;
    for (int column = 0; column <= kState; ++column) std::getline(in, cell, ',');
    return cell == "0";
}

// What the page records of a session is what the servo recorded, number for number, of a body that rings how far; it is
// drawn; and a program that only looks is no device.
TEST_F(LivePage, ShowsASessionAsTheServoRecordsIt) {
    const std::filesystem::path jelly = build_folder() / "ringing";
    if (!std::filesystem::exists(jelly / "servo"))
        GTEST_SKIP() << jelly / "servo"
                     << " is not built: make images";
    start_servo(jelly, "servo.csv");
    const std::string url = serve(jelly);
    Browser& browser = shared_browser();
    open(browser, url);
    EXPECT_TRUE(says(browser, "The servo waits for a device.")) << link(browser);
    browser.key("r");
    Process partner(device({"--seconds", "300", "--path", "poke,drag"}, "tests/firmware/modes.toml"));
    ASSERT_TRUE(
        browser.wait_until("haptable.frame().recorded > 300 && haptable.frame().contact && "
                           "haptable.frame().displacement.some(u => u < -1e-4)"));
    EXPECT_TRUE(says(browser, "this page only looks")) << link(browser);
    press(browser);
    partner.kill(SIGINT);
    EXPECT_EQ(partner.wait_for_exit(), 0);
    browser.key("r");
    ASSERT_TRUE(browser.wait_until("haptable.saved"));
    end_servo();
    const std::vector<std::string> servos = felt(read_file(folder / "servo.csv"));
    const std::set<std::string> known(servos.begin(), servos.end());
    std::size_t same = 0, others = 0;
    for (const std::string& row : felt(browser.evaluate("haptable.saved.csv").get<std::string>()))
        // The servo's last word, with which it falls silent, is no tick.
        if (!is_silent(row)) ++(known.contains(row) ? same : others);
    EXPECT_EQ(others, 0U);
    EXPECT_GT(same, 100U);
    EXPECT_TRUE(lines_of(read_file(folder / "servo.csv"))[0].ends_with(",mode_7,mode_8"));
    EXPECT_EQ(browser.evaluate("haptable.live().goals[0]"), nullptr);
    expect_quiet(browser, url);
}

// A session in lockstep with a page that is opened and closed while it runs has the bytes of one without.
TEST_F(LivePage, ClosingItChangesNothingInTheLoop) {
    for (const bool watched : {false, true}) {
        start_servo(watched ? "watched.csv" : "alone.csv");
        std::optional<Browser> browser;
        if (watched) open(browser.emplace(), serve(cube));
        Process partner(device({"--lockstep", "--seconds", "12", "--path", "poke,drag,circle"}));
        if (watched) {
            EXPECT_TRUE(browser->wait_until("haptable.live().ticks > 0"));
        }
        browser.reset();
        EXPECT_EQ(partner.wait_for_exit(), 0);
        end_servo();
    }
    EXPECT_EQ(read_file(folder / "watched.csv"), read_file(folder / "alone.csv"));
}

// The pointer is the device: the real servo answers. A second page sees it, and cannot touch; with the first closed the
// servo is silent, and the next page has the pointer.
TEST_F(LivePage, ItsPointerIsTheDeviceAndASecondPageLooks) {
    start_servo("servo.csv");
    const std::string url = serve(cube, {"--touch"});
    std::optional<Browser> first(std::in_place);
    open(*first, url);
    EXPECT_TRUE(says(*first, "press on the body")) << link(*first);
    Browser& second = shared_browser();
    open(second, url);
    EXPECT_EQ(first->evaluate("haptable.live().yours"), true);
    EXPECT_EQ(second.evaluate("haptable.live().yours"), false);

    press(*first);
    ASSERT_TRUE(first->wait_until("haptable.frame().contact && haptable.frame().force[2] > 1e-3"))
        << link(*first) << "; goal " << first->evaluate("haptable.live().goals[0]") << ", finger "
        << first->evaluate("[...haptable.frame().finger]") << ", state " << first->evaluate("haptable.frame().state");
    EXPECT_TRUE(first->wait_until("haptable.frame().displacement.some(u => u < -1e-4)"));
    EXPECT_TRUE(says(*first, "your pointer is the device")) << link(*first);
    EXPECT_TRUE(second.wait_until("haptable.frame().contact && haptable.frame().force[2] > 1e-3"));
    EXPECT_TRUE(says(second, "another page has the pointer")) << link(second);
    first->mouse("mouseReleased", top(*first)[0], top(*first)[1]);
    EXPECT_TRUE(first->wait_until("haptable.frame().state === 1 && haptable.frame().force[2] === 0"));
    press(second);
    second.mouse("mouseReleased", top(second)[0], top(second)[1]);
    EXPECT_EQ(second.evaluate("haptable.live().goals[0]"), nullptr);
    // Nor does the server take a wish of it.
    second.evaluate(
        "haptable.live().socket.send(JSON.stringify({kind: 'goal', at: [0.015, 0.015, 0.02], place: true})); "
        "globalThis.before = haptable.live().ticks; 0");
    EXPECT_TRUE(second.wait_until("haptable.live().ticks > before + 500"));
    EXPECT_EQ(second.evaluate("haptable.frame().state === 1 && haptable.frame().finger[2] > 0.03"), true);
    expect_quiet(*first, url);
    expect_quiet(second, url);

    press(*first);
    ASSERT_TRUE(second.wait_until("haptable.frame().contact"));
    first.reset();
    EXPECT_TRUE(second.wait_until("haptable.frame().state === 0")) << "the servo is silent";
    open(second, url);
    EXPECT_EQ(second.evaluate("haptable.live().yours"), true);
    press(second);
    EXPECT_TRUE(second.wait_until("haptable.frame().contact && haptable.frame().force[2] > 1e-3")) << link(second);
    view->kill(SIGINT);
    EXPECT_EQ(view->wait_for_exit(), 0) << read_file(folder / "view.err");
    EXPECT_TRUE(says(second, "The program that serves this page has ended"));
    end_servo();
    double largest_n = 0.0;
    for (const auto& row : read_rows(folder / "servo.csv")) largest_n = std::max(largest_n, row.at("force_z"));
    EXPECT_GT(largest_n, 1e-3);
}

// Both of a session's fingers are drawn, and the body that they lift; and the pointer of a page leads either finger: F
// goes on with the other one.
TEST_F(LivePage, ShowsTwoFingersThatLiftABodyAndItsPointerIsBoth) {
    const std::filesystem::path two = build_folder() / "grasped";
    if (!std::filesystem::exists(two / "servo"))
        GTEST_SKIP() << two / "servo"
                     << " is not built: make images";
    servo.emplace(std::vector<std::string>{(two / "servo").string(), "--lcm", "--no-realtime", "--quiet"});
    const std::string url = serve(two, {"--touch"});
    Browser& browser = shared_browser();
    open(browser, url);
    const std::string both_touch =
        "haptable.frame().contact && haptable.frame().second.contact && haptable.picture().fingers.every(mark => "
        "mark.god.visible) && haptable.frame().second.force.some(f => Math.abs(f) > 1e-3)";
    {
        Process partner({program("haptable-device").string(), "tests/firmware/grasp.toml", "--no-realtime", "--quiet",
                         "--fingers", "2", "--path", "lift", "--hold", "1"});
        EXPECT_TRUE(browser.wait_until(both_touch));
        EXPECT_TRUE(browser.wait_until("haptable.frame().pose.centre[2] > haptable.scene().body.rest_centre[2] + 0.01"))
            << "lifted";
        EXPECT_EQ(partner.wait_for_exit(), 0);  // it has put it down again
    }
    ASSERT_TRUE(browser.wait_until("haptable.frame().state === 0 && haptable.frame().second.state === 0"));
    const auto press_at = [&](double x_m) {  // of the top, where the body is now
        const auto at =
            browser.evaluate(fmt::format("(p => p.project(p.in_world([{}, 0.015, 0.03])))(haptable.picture())", x_m));
        browser.mouse("mouseMoved", at.at(0).get<double>() - 5, at.at(1).get<double>());
        browser.mouse("mousePressed", at.at(0).get<double>(), at.at(1).get<double>());
        return std::array{at.at(0).get<double>(), at.at(1).get<double>()};
    };
    const auto at = press_at(0.010);
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact")) << link(browser);
    browser.key("f");
    browser.mouse("mouseReleased", at[0], at[1]);
    press_at(0.020);
    EXPECT_TRUE(browser.wait_until(both_touch)) << link(browser);
    expect_quiet(browser, url);
    view->kill(SIGINT);
    EXPECT_EQ(view->wait_for_exit(), 0) << read_file(folder / "view.err");
    end_servo();
}

// While a device has the servo, the pointer of a page gets none, and is told so.
TEST_F(LivePage, SaysThatAnotherDeviceHasTheServo) {
    start_servo("servo.csv");
    const std::string url = serve(cube, {"--touch"});
    Process partner(device({"--seconds", "60", "--path", "circle"}));
    Browser& browser = shared_browser();
    open(browser, url);
    ASSERT_TRUE(browser.wait_until("haptable.live().ticks > 0"));
    press(browser);
    EXPECT_TRUE(says(browser, "Another device has the servo")) << link(browser);
}

TEST_F(LivePage, SaysThatItIsServedFromAnotherFolder) {
    write_cube_tables(folder / "other");
    start_servo("servo.csv");
    Process partner(device({"--seconds", "60", "--path", "circle"}));
    const std::string url = serve(folder / "other");
    Browser& browser = shared_browser();
    open(browser, url);
    EXPECT_TRUE(says(browser, "A servo of other tables")) << link(browser);
    EXPECT_NE(read_file(folder / "view.err").find("a servo of other tables"), std::string::npos);
    servo.reset();
    EXPECT_TRUE(browser.wait_until("!haptable.frame().contact"));
}

// What a servo that died has said last is dimmed, and said to be old.
TEST_F(LivePage, DimsWhatADeadServoHasSaid) {
    start_servo("servo.csv");
    const std::string url = serve(cube, {"--touch"});
    Browser& browser = shared_browser();
    open(browser, url);
    ASSERT_TRUE(says(browser, "press on the body"));
    press(browser);
    ASSERT_TRUE(browser.wait_until(
        "haptable.frame().contact && document.getElementById('numbers').textContent.includes('in contact')"));
    EXPECT_FALSE(browser.evaluate("document.getElementById('felt').classList.contains('stale')").get<bool>());
    servo->kill(SIGKILL);
    EXPECT_TRUE(says(browser, "No servo is heard")) << link(browser);
    EXPECT_TRUE(
        browser.wait_until("document.getElementById('numbers').textContent.includes('not heard; was: in contact')"));
    EXPECT_TRUE(browser
                    .evaluate("getComputedStyle(document.querySelector('#force output')).color === "
                              "getComputedStyle(document.querySelector('#numbers dt')).color")
                    .get<bool>());
    EXPECT_LT(browser.evaluate("Number(getComputedStyle(document.getElementById('picture')).opacity)").get<double>(),
              1.0);
}

// Nobody is heard: the page says where, and what to start.
TEST_F(LivePage, SaysThatNoServoIsHeard) {
    const std::string url = serve(cube);
    Browser& browser = shared_browser();
    open(browser, url);
    EXPECT_TRUE(says(browser, "No servo is heard on udpm://239.255.72.84:")) << link(browser);
    EXPECT_TRUE(says(browser, "start build/cube/servo --lcm"));
}

// Only who has the token gets the page or its socket, and only on this machine.
TEST_F(LivePage, AnswersNothingWithoutItsToken) {
    const std::string url = serve(cube);
    const std::size_t begin = url.find('/', 7);
    const std::string at = url.substr(0, begin), wrong = at + "/" + std::string(32, '0') + "/";
    const int port = std::stoi(at.substr(at.rfind(':') + 1));
    Browser& browser = shared_browser();
    for (const std::string& other : {at + "/", wrong, url + "page.html"}) {
        browser.open(other);
        EXPECT_NE(browser.evaluate("document.body.innerText").get<std::string>().find("not the whole address"),
                  std::string::npos)
            << other;
    }
    open(browser, url);
    const auto socket = [&](const std::string& address) {
        return browser
            .evaluate("new Promise(r => { const s = new WebSocket('ws" + address.substr(4) +
                      "session'); s.onopen = () => r('open'); s.onclose = () => r('closed'); })")
            .get<std::string>();
    };
    EXPECT_EQ(socket(url), "open");
    EXPECT_EQ(socket(wrong), "closed");
    EXPECT_EQ(socket(at + "/"), "closed");
    const std::string listening = run(fmt::format("grep ':{:04X} 00000000:0000 0A' /proc/net/tcp*", port)).out;
    EXPECT_NE(listening.find(fmt::format("0100007F:{:04X}", port)), std::string::npos) << listening;
    EXPECT_EQ(lines_of(listening).size(), 1U) << listening;
    const Outcome second =
        run(fmt::format("{} {} --lcm --serve --port {}", program("haptable-view").string(), cube.string(), port));
    EXPECT_EQ(second.status, 1);
    EXPECT_NE(second.err.find(fmt::format("--port {}: is in use", port)), std::string::npos) << second.err;
    EXPECT_EQ(second.out, "");
    const Outcome nowhere = run(program("haptable-view").string() + " no-such-folder --lcm --serve");
    EXPECT_EQ(nowhere.status, 1);
    EXPECT_NE(nowhere.err.find("no-such-folder"), std::string::npos) << nowhere.err;
}

}  // namespace
}  // namespace haptable::test
