// SPDX-License-Identifier: GPL-2.0-or-later
// The page in a browser without a window: opened from the disk, pressed, replayed, damaged.
#include "host/page/page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>

#include "codegen/in_memory.hpp"
#include "codegen/loaded_scene.hpp"
#include "codegen/loads.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/page/columns.hpp"
#include "host/page/modes.hpp"
#include "host/session/servo/replay.hpp"
#include "host/target/strokes.hpp"
#include "host/view/colormap.hpp"
#include "host/view/deformation.hpp"
#include "host/view/drawn_modes.hpp"
#include "tests/browser.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

fs::path parts() { return build_folder() / "lib" / "page"; }

std::string missing() {
    if (!fs::exists(parts() / "servo.wasm") || !fs::exists(parts() / "three.min.js"))
        return "no " + parts().string() + ": make test makes it";
    return Browser::missing();
}

/// One browser for all tests, which takes longer to start than most of them.
Browser& shared_browser() {
    static Browser one;
    return one;
}

/// A cube's tables, the page made of them, and the servo of both.
class TouchPage : public testing::Test {
protected:
    void SetUp() override {
        if (const std::string why = missing(); !why.empty()) GTEST_SKIP() << why;
        write_cube_tables(folder / "cube");
        take("cube");
    }
    /// Makes the page of a folder of tables; `scene`: its servo without limits, as the page has it.
    void take(const std::string& name) {
        SceneFiles files = read_scene_files(TablesFolder(folder / name));
        files.tables.limits = {};
        scene.emplace(std::move(files));
        write_page(folder / name, parts(), page());
    }
    /// The same of a scene.
    void make(const std::string& name, const std::string& text) {
        write_file(folder / "scene.toml", text);
        const Outcome made =
            run(program("haptable-precompute").string() + " scene.toml -o " + name + " --quiet", folder.path());
        ASSERT_EQ(made.status, 0) << made.err;
        take(name);
    }
    const Tables& tables() const { return scene->tables(); }
    fs::path page() const { return folder / "touch.html"; }
    std::string url() const { return "file://" + page().string(); }

    /// What the servo's own replay writes of a path.
    std::string replayed(const std::string& path) {
        write_file(folder / "in.csv", path);
        replay({&scene->model(), scene->node().data(), "cube"}, folder / "in.csv", folder / "out.csv", true);
        return read_file(folder / "out.csv");
    }
    /// What the page has recorded is what the host replays, all fingers and the body.
    std::string expect_the_hosts_record(Browser& browser) {
        EXPECT_TRUE(browser.wait_until("haptable.saved"));
        const auto csv = browser.evaluate("haptable.saved.csv").get<std::string>();
        write_file(folder / "felt.csv", csv);
        replay({&scene->model(), scene->node().data(), "page", scene->pair(), scene->modes(), scene->body()},
               folder / "felt.csv", folder / "again.csv", true);
        EXPECT_EQ(read_file(folder / "again.csv"), csv);
        return csv;
    }

    static void open(Browser& browser, const std::string& url) {
        browser.mouse("mouseReleased", 0, 0);  // as the test before may have left it
        browser.resize(1280, 800);
        browser.open(url);
        ASSERT_EQ(browser.evaluate("haptable.ready.then(() => 'ready', error => error.message)"), "ready");
    }
    /// No error in the console, and nothing asked for but the file itself.
    void expect_quiet(const Browser& browser) const {
        EXPECT_EQ(browser.complaints(), std::vector<std::string>{});
        for (const std::string& request : browser.requests()) EXPECT_EQ(request.substr(0, url().size()), url());
    }

    WorkFolder folder;
    std::optional<LoadedScene> scene;
};

/// Where the middle of the cube's top is on the page.
std::array<double, 2> top(Browser& browser) {
    const auto at = browser.evaluate("haptable.picture().project([0.015, 0.015, 0.03])");
    return {at.at(0).get<double>(), at.at(1).get<double>()};
}

void press(Browser& browser, const std::array<double, 2>& at) {
    browser.mouse("mouseMoved", at[0] - 20, at[1]);
    browser.mouse("mouseMoved", at[0], at[1]);
    browser.mouse("mousePressed", at[0], at[1]);
}

std::string numbers(const std::vector<std::array<float, 3>>& path_m) {
    std::string text = "x,y,z,buttons\n";
    for (std::size_t i = 0; i < path_m.size(); ++i)
        text += fmt::format("{:.9g},{:.9g},{:.9g},{}\n", path_m[i][0], path_m[i][1], path_m[i][2], i / 500 % 8);
    return text;
}

/// Not at the first touch, of which a slow machine may see a frame.
constexpr const char* kDented = "haptable.frame().contact && haptable.frame().displacement.some(u => u < -2e-4)";

/// The displacements that the page shows are the viewer's of its loads and as its modes have swung, to the rounding of
/// its columns.
/// `largest`: of any block of L, m/N. It moves by more than least_m.
void expect_viewers_surface(Browser& browser, const Tables& tables, const fs::path& folder, double epsilon,
                            double largest, double least_m = 1e-4) {
    const auto frame = browser.evaluate(
        "(f => ({fingers: [f, f.second].filter(one => one && one.contact).map(one => ({vertex: Array.from(one.vertex, "
        "v => haptable.scene().node[v]), nodal: Array.from(one.nodal)})), u: Array.from(f.displacement), "
        "swung: f.swung}))"
        "(haptable.frame())");
    std::vector<NodalForce> loads;
    double size_n = 0.0;
    for (const auto& finger : frame.at("fingers"))
        for (std::size_t c = 0; c < 3; ++c) {
            NodalForce load{finger.at("vertex").at(c).get<std::int32_t>(), {}};
            for (std::size_t a = 0; a < 3; ++a) load.force_n[a] = finger.at("nodal").at(3 * c + a).get<float>();
            for (const float f : load.force_n) size_n += std::abs(static_cast<double>(f));
            loads.push_back(load);
        }
    const ContactLoads contact(tables);
    Deformation deformation(tables, folder);
    std::span<const float> u = deformation.displace(contact.spread(loads));
    ContactFrame swung;
    swung.modes = frame.at("swung").get<std::vector<float>>();
    std::optional<DrawnModes> modes = read_drawn_modes(tables, folder);
    if (modes) u = modes->add_to(u, swung);
    const PageRows rows = page_rows(tables);
    ASSERT_EQ(frame.at("u").size(), u.size());
    double moved = 0.0;
    for (std::size_t r = 0; r < rows.node.size(); ++r) {
        const auto at = std::find(tables.row_id.begin(), tables.row_id.end(), rows.node[r]) - tables.row_id.begin();
        for (std::size_t a = 0; a < 3; ++a) {
            const auto wanted = static_cast<double>(u[3 * static_cast<std::size_t>(at) + a]);
            moved = std::max(moved, std::abs(wanted));
            EXPECT_WITHIN(std::abs(frame.at("u").at(3 * r + a).get<double>() - wanted), .count = 8, .epsilon = epsilon,
                          .size = size_n * largest + std::abs(wanted));
        }
    }
    EXPECT_GT(moved, least_m);
}

/// No block of L is larger, m/N.
double largest_block(const Tables& tables) {
    double largest = 0.0;
    for (const auto& s : tables.stiffness) largest = std::max(largest, 3.0 / std::min({s[0], s[4], s[8]}));
    return largest;
}

// From the disk, without a network: the body is drawn, a press is felt and dents it, letting go frees the finger.
TEST_F(TouchPage, OpensFromTheDiskAndIsPressed) {
    Browser& browser = shared_browser();
    open(browser, url());
    const auto at = top(browser);
    const auto body = browser.evaluate(fmt::format("haptable.picture().pixel({}, {})", at[0], at[1] + 40));
    const auto ground = browser.evaluate("haptable.picture().pixel(8, 400)");
    EXPECT_EQ(body.at(3), 255);
    // The processor draws the ground in the page's own colour, a graphics processor none.
    const auto own = browser.evaluate(
        "getComputedStyle(document.documentElement).getPropertyValue('--ground').match(/[0-9a-f]{2}/g)"
        ".map(x => parseInt(x, 16)).concat(255)");
    EXPECT_TRUE(ground == own || ground.at(3) == 0) << ground;
    EXPECT_LT(body.at(0).get<int>(), 0xc0);
    const std::string rest = browser.screenshot();
    EXPECT_EQ(rest.substr(1, 3), "PNG");

    press(browser, at);
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().force[2] > 0"));
    EXPECT_TRUE(browser.wait_until("haptable.frame().displacement.some(u => u < -1e-4)"));
    EXPECT_NE(browser.screenshot(), rest);
    browser.mouse("mouseReleased", at[0], at[1]);
    EXPECT_TRUE(browser.wait_until("haptable.frame().state === 1 && haptable.frame().force[2] === 0"));
    expect_quiet(browser);
}

// A drag beside the body turns it, and the wheel brings it nearer.
TEST_F(TouchPage, TurnsAndZooms) {
    Browser& browser = shared_browser();
    open(browser, url());
    const auto before = browser.evaluate("[haptable.picture().azimuth, haptable.picture().distance]");
    browser.mouse("mousePressed", 30, 400);
    browser.mouse("mouseMoved", 130, 400);
    browser.mouse("mouseReleased", 130, 400);
    browser.mouse("mouseWheel", 400, 400, -100);
    EXPECT_TRUE(browser.wait_until(fmt::format("haptable.picture().azimuth < {} && haptable.picture().distance < {}",
                                               before.at(0).get<double>(), before.at(1).get<double>())));
    EXPECT_EQ(browser.evaluate("haptable.frame().state"), 0);
}

// A touch screen: one finger presses, two come nearer.
TEST_F(TouchPage, IsPressedByAFingerOnTheScreen) {
    Browser& browser = shared_browser();
    open(browser, url());
    browser.resize(1280, 800, true);
    const auto at = top(browser);
    browser.touch("touchStart", {at});
    EXPECT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().force[2] > 0"));
    browser.touch("touchEnd", {});
    EXPECT_TRUE(browser.wait_until("haptable.frame().state === 1"));
    const auto far = browser.evaluate("haptable.picture().distance").get<double>();
    browser.touch("touchStart", {at, {at[0] + 40, at[1]}});
    browser.touch("touchMove", {at, {at[0] + 90, at[1]}});
    browser.touch("touchEnd", {});
    EXPECT_TRUE(browser.wait_until(fmt::format("haptable.picture().distance < {}", far)));
    EXPECT_FALSE(browser.evaluate("haptable.frame().contact").get<bool>());
    expect_quiet(browser);
}

// What the hand did is saved as the servo's CSV, and the host's replay of it writes the same bytes.
TEST_F(TouchPage, RecordsWhatTheHostReplays) {
    Browser& browser = shared_browser();
    open(browser, url());
    press(browser, top(browser));  // what came before is no part of it
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact"));
    browser.key("r");
    browser.mouse("mouseReleased", top(browser)[0], top(browser)[1]);
    ASSERT_TRUE(browser.wait_until("haptable.frame().state === 1"));
    press(browser, top(browser));
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().force[2] > 1e-3"));
    const auto at = top(browser);
    for (int i = 0; i < 10; ++i) browser.mouse("mouseMoved", at[0] + 4 * i, at[1]);
    browser.mouse("mouseReleased", at[0] + 36, at[1]);
    ASSERT_TRUE(browser.wait_until("haptable.frame().state === 1"));
    browser.key("r");
    const std::string csv = expect_the_hosts_record(browser);
    EXPECT_EQ(replayed(finger_path_of(folder / "felt.csv")), csv);
    EXPECT_GT(lines_of(csv).size(), 100U);
    expect_quiet(browser);
}

// A path of hard strokes, replayed in the page and by the host: the same bytes, in the worker as without one.
TEST_F(TouchPage, ReplaysTheHostsBits) {
    const std::string path = numbers(hard_path(tables(), 500));
    const std::string host = replayed(path);
    Browser& browser = shared_browser();
    for (const char* worker : {"on", "off"}) {
        open(browser, url() + "?worker=" + worker);
        EXPECT_EQ(browser.evaluate("Boolean(haptable.without_worker)"), std::string(worker) == "off");
        browser.evaluate("globalThis.file = Data.parse_csv(`" + path + "`); 0");
        EXPECT_EQ(browser.evaluate("haptable.replay(file, 0).then(done => done.csv)"), host) << worker;
        const auto same = browser.evaluate("haptable.play(`" + host + "`)");
        EXPECT_EQ(same.at("same"), same.at("ticks"));
        expect_quiet(browser);
    }
}

// In every mode that the page offers, one that no table of the scene holds among them.
TEST_F(TouchPage, ReplaysEveryModeThatItOffers) {
    const Tables consistent = consistent_by_columns(tables(), folder / "cube");
    const auto path_m = stroke_path(tables(), 50);
    const std::vector<PageMode> modes = page_modes(read_scene_files(folder / "cube"));
    EXPECT_EQ(modes.size(), 8U);
    Browser& browser = shared_browser();
    open(browser, url());
    browser.evaluate("globalThis.file = Data.parse_csv(`" + numbers(path_m) + "`); 0");
    for (std::size_t i = 0; i < modes.size(); ++i) {
        Tables chosen = modes[i].force == ForceLaw::kConsistent ? consistent : tables();
        chosen.god_object = modes[i].god_object;
        chosen.static_friction = chosen.kinetic_friction = modes[i].friction;
        chosen.release_n_per_ms = chosen.god_object == GodObject::kLeastEnergy ? 0.01 : 0.0;
        const ServoModel its_servo = build_model(chosen);
        const haptable_model its = model_in_memory(chosen, its_servo);
        EXPECT_EQ(its.hash, modes[i].hash);
        write_file(folder / "in.csv", numbers(path_m));
        replay({&its, scene->node().data(), "cube"}, folder / "in.csv", folder / "out.csv", true);
        EXPECT_EQ(browser.evaluate(fmt::format("haptable.replay(file, {}).then(done => done.csv)", i)),
                  read_file(folder / "out.csv"))
            << i;
    }
}

// The surface in the page is the viewer's, to the rounding of its columns.
TEST_F(TouchPage, DeformsAsTheViewerDoes) {
    double most_bytes = kPageBytes;
    for (const bool half : {false, true}) {
        const PageReport report = write_page(folder / "cube", parts(), page(), most_bytes);
        EXPECT_EQ(report.columns, half ? "float16" : "float32");
        most_bytes = static_cast<double>(report.bytes) - 1e4;  // too little for float32
        Browser& browser = shared_browser();
        open(browser, url());
        press(browser, top(browser));
        ASSERT_TRUE(browser.wait_until(kDented));
        const double largest = cube_compliance({0.015, 0.015, 0.03}, {0.015, 0.015, 0.03}).cwiseAbs().maxCoeff();
        expect_viewers_surface(browser, tables(), folder / "cube", half ? kHalf : kFloat, largest);
    }
}

// A mask loads the nodes under it, not the patch's corners alone.
TEST_F(TouchPage, SpreadsAMaskAsTheViewerDoes) {
    ASSERT_NO_FATAL_FAILURE(make("cube-mask", R"(name = "mask"
[mesh]
generate = "cube"
[material]
young = 1e4
poisson = 0.3
[[fixed]]
box = [-1, -1, -1, 1, 1, 1e-9]
[contact]
force = "pressure-mask"
mask_radius = 0.012
)"));
    Browser& browser = shared_browser();
    open(browser, url());
    press(browser, top(browser));
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().force[2] > 0.01"));
    expect_viewers_surface(browser, tables(), folder / "cube-mask", kFloat, largest_block(tables()));
    expect_quiet(browser);
}

/// A page for two fingers, and the servo of both.
class TouchPageOfTwo : public TouchPage {
protected:
    void SetUp() override {
        if (const std::string why = missing(); !why.empty()) GTEST_SKIP() << why;
        ASSERT_NO_FATAL_FAILURE(make("two", R"(name = "two"
[mesh]
generate = "cube"
[material]
young = 1e4
poisson = 0.3
[[fixed]]
box = [-1, -1, -1, 1, 1, 1e-9]
[contact]
force = "consistent"
god_object = "least-energy"
fingers = 2
)"));
    }
    static std::array<double, 2> at(Browser& browser, const char* where) {
        const auto at = browser.evaluate(fmt::format("haptable.picture().project({})", where));
        return {at.at(0).get<double>(), at.at(1).get<double>()};
    }
};

// F leaves the finger in its dent and takes up the other, which presses beside it: the first one's force falls, for the
// surface gives way under it. Both are drawn. What was recorded is what the host replays.
TEST_F(TouchPageOfTwo, OneFingerFeelsTheOther) {
    Browser& browser = shared_browser();
    open(browser, url());
    EXPECT_EQ(browser.evaluate("getComputedStyle(document.querySelector('.two')).display !== 'none'"), true);
    browser.key("r");
    const auto one = at(browser, "[0.009, 0.015, 0.03]"), other = at(browser, "[0.021, 0.015, 0.03]");
    press(browser, one);
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().force[2] > 0.01"));
    browser.key("f");
    browser.mouse("mouseReleased", one[0], one[1]);
    // At rest: a hand of 5 N s/m has no more to go.
    ASSERT_TRUE(browser.wait_until(
        "(t => (globalThis.begun = globalThis.begun || t, t > begun + 1500))(haptable.frame().tick)"));
    const double alone_n = browser.evaluate("haptable.frame().force[2]").get<double>();
    EXPECT_EQ(browser.evaluate("haptable.frame().second.state"), 0);
    press(browser, other);
    ASSERT_TRUE(browser.wait_until("haptable.frame().second.contact && haptable.frame().second.force[2] > 0.01"));
    ASSERT_TRUE(browser.wait_until(fmt::format("haptable.frame().force[2] < {}", 0.95 * alone_n)));
    EXPECT_TRUE(browser.evaluate("haptable.frame().contact").get<bool>()) << "it is where it was left";
    EXPECT_TRUE(browser.evaluate("haptable.picture().fingers.every(mark => mark.god.visible && mark.arrow.visible)"));
    expect_viewers_surface(browser, tables(), folder / "two", kFloat, largest_block(tables()));
    EXPECT_TRUE(browser.wait_until("document.querySelectorAll('#force output').length === 2"));
    browser.mouse("mouseReleased", other[0], other[1]);
    ASSERT_TRUE(browser.wait_until("haptable.frame().second.state === 1"));
    browser.key("r");
    const std::string csv = expect_the_hosts_record(browser);
    const auto again = browser.evaluate("haptable.play(`" + csv + "`)");
    EXPECT_EQ(again.at("same"), again.at("ticks"));
    expect_quiet(browser);
}

// A body that nothing holds is pushed aside: it is drawn, pressed again and recorded where it is, as the host has it.
TEST_F(TouchPage, PushesABodyThatNothingHolds) {
    ASSERT_NO_FATAL_FAILURE(make("loose", R"(name = "loose"
[mesh]
generate = "cube"
[material]
young = 2e4
poisson = 0.3
[gravity]
density = 1000.0
[body]
free = true
floor = 0.0
floor_friction = 0.3
[contact]
friction = 0.8
)"));
    Browser& browser = shared_browser();
    open(browser, url());
    browser.key("r");
    const auto side = [&](double y_m) {  // of the face that is seen in front
        const auto at = browser.evaluate(fmt::format("haptable.picture().project([0.015, {}, 0.015])", y_m));
        return std::array{at.at(0).get<double>(), at.at(1).get<double>()};
    };
    press(browser, side(0.0));
    ASSERT_TRUE(browser.wait_until("haptable.frame().pose && haptable.frame().pose.centre[1] > 0.0165"));
    EXPECT_TRUE(browser.wait_until("haptable.picture().body.position.y > 0.02")) << "of the diagonal, 52 mm";
    browser.mouse("mouseReleased", side(0.0)[0], side(0.0)[1]);
    ASSERT_TRUE(browser.wait_until("haptable.frame().state === 1"));
    ASSERT_TRUE(browser.wait_until(
        "(f => { const was = globalThis.was || {tick: 0, y: 0}, y = f.pose.centre[1]; if (f.tick < was.tick + 50) "
        "return "
        "false; globalThis.was = {tick: f.tick, y}; return Math.abs(y - was.y) < 1e-6; })(haptable.frame())"))
        << "it comes to rest";
    // The pointer finds its face where that is now: on y = 0 of the body, which has moved.
    const auto hit = browser.evaluate(
        "(p => { const at = p.project(p.in_world([0.015, 0, 0.015])), x = p.pick(...at).at_m, seen = p.project(x); "
        "return [x[1], p.into_body({origin: x, direction: x}).origin[1], Math.hypot(seen[0] - at[0], seen[1] - "
        "at[1])]; "
        "})(haptable.picture())");
    EXPECT_GT(hit.at(0).get<double>(), 1e-3);
    EXPECT_WITHIN(std::abs(hit.at(1).get<double>()), .count = 32, .epsilon = kFloat, .size = 0.052);
    EXPECT_WITHIN(hit.at(2).get<double>(), .count = 32, .epsilon = kFloat, .size = 1280.0) << "pixels";
    // Pressed from above the god-object is over the finger, though the body's frame has moved farther than that.
    press(browser, browser.evaluate("(p => p.project(p.in_world([0.015, 0.015, 0.03])))(haptable.picture())")
                       .get<std::array<double, 2>>());
    EXPECT_TRUE(
        browser.wait_until("(f => f.contact && Math.hypot(f.god[0] - f.finger[0], f.god[1] - f.finger[1]) < 1e-3)"
                           "(haptable.frame())"));
    browser.key("r");
    expect_the_hosts_record(browser);
    browser.command("Input.dispatchKeyEvent", {{"type", "keyDown"}, {"key", "Home"}});
    EXPECT_TRUE(browser.wait_until("haptable.frame().pose.centre[1] === haptable.scene().body.rest_centre[1]"));
    expect_quiet(browser);
}

// A body that is pressed and let go rings in the picture, held or free, and what was recorded is what the host replays.
TEST_F(TouchPage, RingsWhenItIsLetGo) {
    for (const bool is_free : {false, true}) {
        const std::string rest = is_free
                                     ? "free = true\nfloor = 0.0\n[contact]\nforce = \"pressure-mask\"\n"
                                       "god_object = \"nearest\"\nmask_radius = 0.012\n"
                                     : "[contact]\nforce = \"consistent\"\n[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n";
        const std::string name = is_free ? "loose" : "held";
        ASSERT_NO_FATAL_FAILURE(make(name, R"(name = "jelly"
[mesh]
generate = "cube"
nodes_per_side = 4
[material]
young = 6e3
poisson = 0.3
[gravity]
density = 1000.0
[body]
modes = 3
mode_damping = 0.001
)" + rest));
        Browser& browser = shared_browser();
        open(browser, url());
        browser.key("r");
        press(browser, top(browser));
        ASSERT_TRUE(browser.wait_until(kDented));
        browser.mouse("mouseReleased", top(browser)[0], top(browser)[1]);
        ASSERT_TRUE(browser.wait_until("haptable.frame().state === 1"));
        // Free, it is drawn as the modes have it, and they go on to the other side.
        for (const char* side : {"<", ">"})
            EXPECT_TRUE(browser.wait_until(fmt::format("haptable.frame().swung[0] {} 0", side))) << side;
        expect_viewers_surface(browser, tables(), folder / name, kFloat, largest_block(tables()), 0.0);
        browser.key("r");
        expect_the_hosts_record(browser);
        expect_quiet(browser);
    }
}

// A path of one finger is felt as in a scene with one; one of two is refused by a page of one.
TEST_F(TouchPageOfTwo, ReplaysAPathOfOneFinger) {
    const std::string path = numbers(stroke_path(tables(), 5));
    Browser& browser = shared_browser();
    open(browser, url());
    browser.evaluate("globalThis.file = Data.parse_csv(`" + path + "`, 2); 0");
    const auto both = browser.evaluate("haptable.replay(file, 0).then(done => done.csv)").get<std::string>();
    const std::vector<std::string> rows = lines_of(both), alone = lines_of(replayed(path));
    ASSERT_EQ(rows.size(), alone.size());
    for (std::size_t i = 1; i < rows.size(); ++i)
        ASSERT_EQ(rows[i].substr(0, alone[i].size() + 12), alone[i] + ",nan,nan,nan");
    const auto error = browser.evaluate(
        "(() => { try { Data.parse_csv('x,y,z,x2,y2,z2\\n0,0,0,0,0,0\\n'); } catch (error) { return error.message; } "
        "return ''; })()");
    EXPECT_NE(error.get<std::string>().find("of two fingers"), std::string::npos) << error;
}

// A file that was copied half says so, wherever it ends; one whose tables were changed too.
TEST_F(TouchPage, SaysWhereItIsDamaged) {
    const std::string whole = read_file(page());
    Browser& browser = shared_browser();
    const auto said = [&](const std::string& text) {
        write_file(page(), text);
        browser.open(url());
        EXPECT_TRUE(browser.wait_until("!document.getElementById('failed').hidden"));
        return browser.evaluate("document.getElementById('failed').innerText").get<std::string>();
    };
    const std::size_t data = whole.find("id=\"data\"");
    for (const std::size_t end : {whole.find("</style>") + 2000, data - 1000, data + 5000, whole.size() - 40})
        EXPECT_NE(said(whole.substr(0, end)).find("This file is cut off."), std::string::npos) << end;
    std::string changed = whole;
    changed[data + 3000] = changed[data + 3000] == 'A' ? 'B' : 'A';
    EXPECT_NE(said(changed).find("its tables are not those that were written"), std::string::npos);
}

// Without WebGL there is no picture: it says so, and the servo runs all the same.
TEST_F(TouchPage, SaysThatThereIsNoWebGL) {
    Browser browser({"--disable-3d-apis"});
    open(browser, url());
    EXPECT_TRUE(browser.wait_until("document.body.innerText.includes('This browser gives no WebGL')"));
    const std::string path = numbers(stroke_path(tables(), 5));
    browser.evaluate("globalThis.file = Data.parse_csv(`" + path + "`); 0");
    EXPECT_EQ(browser.evaluate("haptable.replay(file, 0).then(done => done.csv)"), replayed(path));
}

/// The page as it is seen: what is at a place of a screenshot, [r, g, b].
std::array<int, 3> seen(Browser& browser, int x, int y) {
    const std::string png = browser.screenshot();
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0);
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
    const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width + static_cast<std::size_t>(x));
    return {pixels.at(at), pixels.at(at + 1), pixels.at(at + 2)};
}

/// Elements of the page by a selector, in words of it, for which a condition on `e` holds.
std::string which(Browser& browser, const std::string& selector, const std::string& condition) {
    return browser
        .evaluate(fmt::format("Array.from(document.querySelectorAll('{}')).filter(e => {}).map(e => e.id || "
                              "e.textContent).join(' | ')",
                              selector, condition))
        .get<std::string>();
}

// At 1280 x 720, with a bar of 15 pixels beside the column: no number is cut off, whatever the force's size, no bar
// lies across, and what can be set is seen.
TEST_F(TouchPage, ShowsAllNumbersAndControls) {
    Browser& browser = shared_browser();
    open(browser, url());
    browser.resize(1280, 720);
    browser.evaluate("document.querySelector('aside').style.paddingRight = '23px'; 0");
    press(browser, top(browser));
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && Math.hypot(...haptable.frame().force) > 0.1"));
    ASSERT_TRUE(browser.wait_until("document.getElementById('numbers').textContent.includes('in contact')"));
    EXPECT_EQ(
        which(browser, "aside, aside *", "e.scrollWidth > e.clientWidth && getComputedStyle(e).display !== \"inline\""),
        "");
    EXPECT_EQ(which(browser, "#numbers dd", "e.getBoundingClientRect().height > 20"), "") << "on a line each";
    EXPECT_EQ(which(browser, "aside select, aside button, aside input:not([hidden])",
                    "e.getBoundingClientRect().bottom > innerHeight"),
              "");
    EXPECT_TRUE(browser.evaluate("document.documentElement.scrollWidth <= innerWidth").get<bool>());
    expect_quiet(browser);
}

// While it loads, the title stands on the page's ground: a canvas that nothing was drawn on is black.
TEST_F(TouchPage, IsNotBlackWhileItLoads) {
    Browser& browser = shared_browser();
    const auto stub = browser.command("Page.addScriptToEvaluateOnNewDocument",
                                      {{"source", "WebAssembly.instantiate = () => new Promise(() => {});"}});
    for (const char* theme : {"light", "dark"}) {
        browser.open(url() + "?worker=off&theme=" + theme);
        ASSERT_TRUE(browser.wait_until("haptable.picture()"));
        EXPECT_GT(seen(browser, 8, 200)[0], theme == std::string("light") ? 0xe0 : 0x0a) << theme;
    }
    browser.command("Page.removeScriptToEvaluateOnNewDocument", {{"identifier", stub.at("identifier")}});
}

// Whoever hears the page or has no pointer: all controls have a name, the focus is drawn, and keys work while a slider
// has it, but those that move the slider.
TEST_F(TouchPage, IsUsedByKeys) {
    Browser& browser = shared_browser();
    open(browser, url());
    browser.command("Accessibility.enable");
    const auto tree = browser.command("Accessibility.getFullAXTree");
    int sliders = 0;
    for (const auto& node : tree.at("nodes")) {
        const std::string role = node.value("/role/value"_json_pointer, "");
        if (role != "slider" && role != "combobox" && role != "button" && role != "checkbox") continue;
        sliders += role == "slider" ? 1 : 0;
        EXPECT_NE(node.value("/name/value"_json_pointer, ""), "") << role;
        if (role == "slider") {
            EXPECT_NE(node.dump().find("valuetext"), std::string::npos) << node.at("name");
        }
    }
    EXPECT_EQ(sliders, 3);

    const std::array<int, 3> before = seen(browser, 1, 300);
    browser.evaluate("document.activeElement.blur(); 0");
    browser.key("Tab");
    EXPECT_EQ(browser.evaluate("document.activeElement.id"), "stage");
    EXPECT_NE(seen(browser, 1, 300), before);
    browser.evaluate("document.getElementById('depth').focus(); 0");
    EXPECT_NE(browser.evaluate("getComputedStyle(document.activeElement).outlineStyle"), "none");
    const auto azimuth = browser.evaluate("haptable.picture().azimuth");
    const auto depth = browser.evaluate("Number(document.getElementById('depth').value)").get<double>();
    browser.key("ArrowRight");
    EXPECT_GT(browser.evaluate("Number(document.getElementById('depth').value)").get<double>(), depth);
    EXPECT_EQ(browser.evaluate("haptable.picture().azimuth"), azimuth) << "the arrow is the slider's";
    browser.key("p");
    EXPECT_TRUE(browser.wait_until("haptable.frame().contact"));
    browser.key("p");
    EXPECT_TRUE(browser.wait_until("haptable.frame().state === 1"));
    expect_quiet(browser);
}

// WCAG 2: 4.5 to 1 of all text, in both themes; the ground of the stage is the worse of its two ends.
TEST_F(TouchPage, ItsTextIsReadable) {
    Browser& browser = shared_browser();
    for (const char* theme : {"light", "dark"}) {
        open(browser, url() + "?theme=" + theme);
        press(browser, top(browser));
        ASSERT_TRUE(browser.wait_until("document.getElementById('numbers').textContent.includes('in contact')"));
        const auto poor = browser.evaluate(R"((() => {
            const rgb = text => text.match(/[\d.]+/g).map(Number);
            const linear = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
            const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
            const ratio = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
            const probe = document.body.appendChild(document.createElement('i'));
            const named = name => { probe.style.color = `var(--${name})`; return rgb(getComputedStyle(probe).color); };
            const grounds = e => {
                for (; e; e = e.parentElement) {
                    if (e.id === 'stage') return [named('ground'), named('ground-low')];
                    const back = rgb(getComputedStyle(e).backgroundColor);
                    if (back.length === 3 || back[3] === 1) return [back];
                }
                return [named('ground')];
            };
            const poor = [];
            let texts = 0;
            const judge = (what, ink, on) => {
                ++texts;
                const worst = Math.min(...on.map(ground => ratio(ink, ground)));
                if (worst < 4.5) poor.push(what + ' ' + worst.toFixed(2));
            };
            for (const link of ['', 'trouble']) {
                document.getElementById('link').hidden = false;
                document.getElementById('link').className = link;
                document.getElementById('link').textContent = 'link ' + link;
                document.getElementById('record').classList.toggle('on', link !== '');
                for (const e of document.querySelectorAll('body *')) {
                    const own = Array.from(e.childNodes).some(n => n.nodeType === 3 && n.textContent.trim());
                    if (own && !/^(SCRIPT|STYLE|NOSCRIPT)$/.test(e.tagName) && !e.disabled && !e.closest('#failed'))
                        judge(e.textContent.slice(0, 30), rgb(getComputedStyle(e).color), grounds(e));
                }
            }
            for (const axis of ['axis-x', 'axis-y', 'axis-z', 'quiet']) judge(axis, named(axis), [named('ground'), named('ground-low')]);
            judge('plots', named('quiet'), [named('card')]);
            probe.remove();
            return texts < 60 ? 'only ' + texts : poor.join(', ');
        })())");
        EXPECT_EQ(poor, "") << theme;
    }
}

// Finger, god-object and force are drawn in the viewer's colours, and its legend says so; dark, in those for it.
TEST_F(TouchPageOfTwo, HasTheViewersColours) {
    Browser& browser = shared_browser();
    for (const bool dark : {false, true}) {
        open(browser, url() + (dark ? "?theme=light" : "?theme=dark"));
        browser.key("l");  // the other one
        for (const auto& [name, mark] : {std::pair("finger", "fingers[0].finger.children[0]"),
                                         {"second_finger", "fingers[1].finger.children[0]"},
                                         {"god_object", "fingers[1].god.children[0]"},
                                         {"force", "fingers[0].shaft.children[0]"}}) {
            const auto* color = std::find_if(kDrawnColors.begin(), kDrawnColors.end(),
                                             [name = name](const DrawnColor& one) { return one.name == name; });
            ASSERT_NE(color, kDrawnColors.end());
            EXPECT_EQ(browser.evaluate(fmt::format("haptable.picture().{}.material.color.getHex()", mark)),
                      dark ? color->on_dark : color->on_light)
                << name;
        }
        ASSERT_TRUE(browser.wait_until("document.querySelector('#legend i:not(.part)') !== null"));
        EXPECT_EQ(browser.evaluate("Array.from(document.querySelectorAll('#legend i:not(.part)'), e => "
                                   "getComputedStyle(e).backgroundColor).join()"),
                  browser.evaluate("[haptable.picture().fingers[0].finger, haptable.picture().fingers[1].finger, "
                                   "haptable.picture().fingers[0].god, haptable.picture().fingers[0].shaft].map(m => "
                                   "'rgb(' + m.children[0].material.color.toArray().map(x => Math.round(255 * "
                                   "x)).join(', ') + ')').join()"));
    }
}

// On a phone: help, legend, and a second touch on the body is the second finger; beside the body it brings nearer.
TEST_F(TouchPageOfTwo, IsTouchedByTwoFingersOnAPhone) {
    Browser& browser = shared_browser();
    open(browser, url());
    browser.resize(390, 844, true);
    ASSERT_TRUE(browser.wait_until("haptable.picture().width === 390"));
    EXPECT_EQ(which(browser, "#legend, #ask, #hint .by_touch", "e.getClientRects().length === 0"), "");
    EXPECT_TRUE(browser.evaluate("document.documentElement.scrollWidth <= innerWidth").get<bool>());
    const auto one = at(browser, "[0.009, 0.015, 0.03]"), other = at(browser, "[0.021, 0.015, 0.03]");
    browser.touch("touchStart", {one});
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact"));
    browser.touch("touchStart", {one, other});
    ASSERT_TRUE(browser.wait_until("haptable.frame().contact && haptable.frame().second.contact"));
    browser.touch("touchEnd", {});
    ASSERT_TRUE(browser.wait_until("haptable.frame().state === 1 && haptable.frame().second.state === 1"));
    const auto far = browser.evaluate("haptable.picture().distance").get<double>();
    browser.touch("touchStart", {one, {12, 300}});
    browser.touch("touchMove", {{one[0] + 60, one[1]}, {12, 300}});
    browser.touch("touchEnd", {});
    EXPECT_TRUE(browser.wait_until(fmt::format("haptable.picture().distance < {}", far)));
    browser.evaluate("document.getElementById('ask').click(); 0");
    EXPECT_TRUE(browser.evaluate("document.getElementById('help').open").get<bool>());
    browser.evaluate("document.getElementById('help').close(); 0");
    expect_quiet(browser);
}

// Where pictures get coarser, axes and scale bar stay.
TEST_F(TouchPage, KeepsItsAxesAsPicturesGetCoarser) {
    Browser& browser = shared_browser();
    open(browser, url());
    const char* drawn =
        "(c => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0))"
        "(document.getElementById('overlay'))";
    EXPECT_TRUE(browser.wait_until(drawn));
    browser.evaluate("haptable.picture().coarser(); haptable.picture().draw(); 0");
    EXPECT_TRUE(browser.evaluate(drawn).get<bool>());
}

// A CSV that is none is told by its line, and the page goes on.
TEST_F(TouchPage, TellsWhatIsWrongWithACsv) {
    Browser& browser = shared_browser();
    open(browser, url());
    const auto error = [&](const std::string& csv) {
        return browser.evaluate("haptable.play(`" + csv + "`).then(() => '', error => error.message)")
            .get<std::string>();
    };
    EXPECT_NE(error("a,b\n1,2\n").find("line 1"), std::string::npos);
    EXPECT_NE(error("x,y,z\n0,0,0\n0,0\n").find("line 3"), std::string::npos);
    EXPECT_NE(error("x,y,z\n0,zero,0\n").find("line 2"), std::string::npos);
    EXPECT_EQ(error("x,y,z\n0,nan,inf\n0.01,0.01,0.04\n"), "");
    EXPECT_EQ(error("x,y,z\n0.015,0.015,0.04\n15,15,29.5\n"),
              "line 3 (15, 15, 29.5) looks like millimetres, and a path is in metres: divide its places by 1000");
    EXPECT_EQ(error("x,y,z\n15000,15,29.5\n"), "") << "far in millimetres too";
}

class PageProgram : public testing::Test {
protected:
    Outcome view(const std::string& words) const {
        return run(program("haptable-view").string() + " " + words, folder.path());
    }
    WorkFolder folder;
};

// What a wrong folder, a page that is too large, and tables without columns get: one line, and no file.
TEST_F(PageProgram, SaysWhatItCannotMakeAPageOf) {
    if (const std::string why = missing(); !why.empty()) GTEST_SKIP() << why;
    write_cube_tables(folder / "cube");
    write_cube_tables(folder / "bare", {.columns = "none"});
    const auto error = [&](const std::string& words) {
        const Outcome ended = view(words + " --page touch.html");
        EXPECT_EQ(ended.status, 1) << words;
        EXPECT_EQ(lines_of(ended.err).size(), 1U) << ended.err;
        EXPECT_FALSE(fs::exists(folder / "touch.html"));
        return ended.err;
    };
    EXPECT_NE(error("nowhere").find("nowhere/tables.json"), std::string::npos);
    EXPECT_NE(error("cube --megabytes 0.5").find("--megabytes"), std::string::npos);
    EXPECT_NE(error("bare").find("columns"), std::string::npos);
    EXPECT_EQ(view("cube --page touch.html -o pictures").status, 2);
    EXPECT_EQ(view("cube --mesh").status, 2);
    EXPECT_EQ(view("cube --page touch.html --quiet").status, 0);
    EXPECT_TRUE(fs::exists(folder / "touch.html"));
}

}  // namespace
}  // namespace haptable::test
