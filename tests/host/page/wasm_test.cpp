// SPDX-License-Identifier: GPL-2.0-or-later
// The servo as WebAssembly, in a browser without a window: the host's bits, for every force and god-object.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>

#include "codegen/in_memory.hpp"
#include "codegen/model_bytes.hpp"
#include "codegen/pair.hpp"
#include "firmware/haptable_scene.h"
#include "host/base/file.hpp"
#include "host/page/base64.hpp"
#include "host/session/local_stepper.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/bodies.hpp"
#include "tests/browser.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/moving_body.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

constexpr std::size_t kTicks = 100000;  // of a mode, over both bodies

/// Of a page's struct page_tick.
struct PageTick {
    std::uint32_t state;
    std::int32_t patch, vertex[3];
    float finger_m[3], alpha[3], god_object_m[3], force_n[3], nodal_force_n[3][3];
    std::uint32_t buttons, faults;
};

std::filesystem::path module() { return build_folder() / "lib" / "page" / "servo.wasm"; }

std::string missing_servo() {
    if (!std::filesystem::exists(module())) return "no " + module().string() + ": make test makes it";
    return Browser::missing();
}

/// One browser for all tests, with the module in it and two words to use it.
Browser& browser() {
    static std::unique_ptr<Browser> one;
    if (one) return *one;
    one = std::make_unique<Browser>();
    one->evaluate(R"(
        globalThis.bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
        globalThis.text = bytes => {
            let all = '';
            for (let i = 0; i < bytes.length; i += 8192) all += String.fromCharCode(...bytes.subarray(i, i + 8192));
            return btoa(all);
        };
        globalThis.kept = wasm => b => {
            const at = wasm.page_reserve(b.length);
            new Uint8Array(wasm.memory.buffer, at, b.length).set(b);
            return at;
        };
        0)");
    one->evaluate("WebAssembly.compile(bytes('" + to_base64(read_file(module())) +
                  "')).then(module => { globalThis.module = module; return 1; })");
    return *one;
}

std::string js_bytes(std::string_view bytes) { return "bytes('" + to_base64(bytes) + "')"; }

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// The ticks of a path by a fresh module.
std::vector<PageTick> in_browser(const haptable_model& model, const std::vector<std::array<float, 3>>& path_m) {
    const std::string ticks = from_base64(
        browser()
            .evaluate(
                "WebAssembly.instantiate(module, {}).then(instance => {"
                "const wasm = instance.exports, keep = kept(wasm), model = " +
                js_bytes(model_bytes(model)) + ", path = " + js_bytes(bytes_of(path_m)) +
                ";const m = wasm.page_model(keep(model), model.length), at = keep(path), count = path.length / 12;"
                "const out = wasm.page_reserve(112 * count);"
                "wasm.page_begin(m, 0, 0); wasm.page_replay(at, 0, count, out);"
                "return text(new Uint8Array(wasm.memory.buffer, out, 112 * count)); })")
            .get<std::string>());
    static_assert(sizeof(PageTick) == 112);
    std::vector<PageTick> all(ticks.size() / sizeof(PageTick));
    std::memcpy(all.data(), ticks.data(), all.size() * sizeof(PageTick));
    return all;
}

template <typename A, typename B>
bool same_bits(const A& a, const B& b) {
    static_assert(sizeof(A) == sizeof(B));
    return std::memcmp(&a, &b, sizeof a) == 0;
}

bool same(const PageTick& a, const haptable_output& b) {
    const bool corners = std::equal(a.vertex, a.vertex + 3, b.vertex, [](std::int32_t v, std::uint16_t w) {
        return v == (w == HAPTABLE_NONE ? -1 : std::int32_t{w});
    });
    return corners && a.state == b.state && same_bits(a.alpha, b.alpha) && same_bits(a.god_object_m, b.god_object_m) &&
           same_bits(a.force_n, b.force_n) && same_bits(a.nodal_force_n, b.nodal_force_n);
}

/// Strokes in and out, over edges and through thin parts, with positions that are none: half of kTicks.
std::vector<std::array<float, 3>> long_path(const Tables& tables) {
    std::vector<std::array<float, 3>> path_m = hard_path(tables, static_cast<int>(kTicks) / 80);
    const auto more = stroke_path(tables, static_cast<int>(kTicks) / 160);
    path_m.insert(path_m.end(), more.begin(), more.end());
    return path_m;
}

class ModeInBrowser : public testing::TestWithParam<Mode> {};

std::string name_of(const testing::TestParamInfo<Mode>& info) { return test_name(info.param.name()); }

INSTANTIATE_TEST_SUITE_P(Modes, ModeInBrowser, testing::ValuesIn(every_mode()), name_of);

TEST_P(ModeInBrowser, GivesTheHostsBits) {
    if (const std::string why = missing_servo(); !why.empty()) GTEST_SKIP() << why;
    for (const char* name : {"cube", "needle"}) {
        const ElasticBody& touched = body_of_modes(name, GetParam().force);
        const haptable_model model = in_mode(touched.model(), GetParam());
        const auto path_m = long_path(touched.tables());
        ASSERT_GE(2 * path_m.size(), kTicks);
        const std::vector<PageTick> ticks = in_browser(model, path_m);
        ASSERT_EQ(ticks.size(), path_m.size());
        haptable_room room{};
        haptable_servo& servo = room.fingers.servo[0];
        haptable_servo_init(&servo);
        for (std::size_t i = 0; i < path_m.size(); ++i) {
            haptable_output out;
            haptable_servo_step(&model, &servo, path_m[i].data(), static_cast<std::uint32_t>(i * 1000), &out);
            ASSERT_TRUE(same(ticks[i], out)) << name << " tick " << i;
        }
        EXPECT_GT(servo.counters.contact_ticks, path_m.size() / 3) << name;
    }
}

// Blocks in 16 bits are unpacked there too.
TEST(PackedInBrowser, GivesTheHostsBits) {
    if (const std::string why = missing_servo(); !why.empty()) GTEST_SKIP() << why;
    for (const ForceLaw force : every<ForceLaw>())
        for (const Storage precision : {Storage::kFloat16, Storage::kInt16}) {
            Tables tables = body_of_modes("cube", force).tables();
            tables.precision = precision;
            const ServoModel servo_model = build_model(tables);
            const haptable_model model = model_in_memory(tables, servo_model);
            const auto path_m = stroke_path(tables, 100);
            const std::vector<PageTick> ticks = in_browser(model, path_m);
            haptable_servo servo;
            haptable_servo_init(&servo);
            for (std::size_t i = 0; i < path_m.size(); ++i) {
                haptable_output out;
                haptable_servo_step(&model, &servo, path_m[i].data(), static_cast<std::uint32_t>(i * 1000), &out);
                ASSERT_TRUE(same(ticks[i], out)) << word(force) << " " << word(precision) << " tick " << i;
            }
        }
}

/// Of two fingers, and where the body is that nothing holds.
struct PageRecord {
    std::array<PageTick, kFingers> tick;
    std::array<float, 3> centre_m{};
    std::array<float, 4> turn{};
};

/// The ticks of two fingers by a fresh module. path_m, buttons: [ticks, 2]. body: null where it is held.
std::vector<PageRecord> both_in_browser(const haptable_pair_model& pair, const haptable_body* body,
                                        const std::vector<std::array<float, 3>>& path_m,
                                        const std::vector<std::uint32_t>& buttons) {
    const std::string_view moving(reinterpret_cast<const char*>(body), body != nullptr ? sizeof *body : 0);
    const std::size_t size = 2 * sizeof(PageTick) + (body != nullptr ? 28 : 0);
    const std::string words = from_base64(
        browser()
            .evaluate("WebAssembly.instantiate(module, {}).then(instance => {"
                      "const wasm = instance.exports, keep = kept(wasm), model = " +
                      js_bytes(model_bytes(*pair.model)) + ", coupling = " + js_bytes(coupling_bytes(pair)) +
                      ", path = keep(" + js_bytes(bytes_of(path_m)) + "), held = keep(" + js_bytes(bytes_of(buttons)) +
                      "), body = " + js_bytes(moving) +
                      fmt::format(", count = {}, size = {};", path_m.size() / 2, size) +
                      "const m = wasm.page_model(keep(model), model.length);"
                      "const p = wasm.page_coupling(m, keep(coupling), coupling.length);"
                      "if (body.length) wasm.page_body(keep(body), body.length);"
                      "const out = wasm.page_reserve(size * count);"
                      "wasm.page_begin(m, p, 0); wasm.page_replay(path, held, count, out);"
                      "return text(new Uint8Array(wasm.memory.buffer, out, size * count)); })")
            .get<std::string>());
    std::vector<PageRecord> all(words.size() / size);
    for (std::size_t i = 0; i < all.size(); ++i) std::memcpy(&all[i], &words[i * size], size);
    return all;
}

/// Two fingers on a body that is held, or on one that they push about its floor; each away now and then.
class BothInBrowser : public testing::TestWithParam<bool> {};

INSTANTIATE_TEST_SUITE_P(Bodies, BothInBrowser, testing::Bool(),
                         [](const auto& free) { return free.param ? "Free" : "Held"; });

TEST_P(BothInBrowser, GiveTheHostsBits) {
    if (const std::string why = missing_servo(); !why.empty()) GTEST_SKIP() << why;
    constexpr std::uint32_t kAway = 0x80000000U;
    const SoftPair two(0.5);
    ServoScene scene = two.scene();
    haptable_body cube = cube_body();
    add_gravity(cube);
    add_floor(cube, 0.0, 0.5);
    const haptable_body* body = GetParam() ? &cube : nullptr;
    std::vector<std::array<float, 3>> path_m;
    std::vector<std::uint32_t> buttons;
    const auto first = stroke_path(two.tables(), 100);
    for (std::size_t i = 0; i < first.size(); ++i)
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            path_m.push_back(first[finger == 0 ? i : first.size() - 1 - i]);
            buttons.push_back(i % 700 < 30 * finger || i % 900 > 880 ? kAway : 0U);
        }
    const std::vector<PageRecord> records = both_in_browser(*scene.pair, body, path_m, buttons);
    ASSERT_EQ(records.size(), first.size());
    scene.body = body;
    LocalStepper fingers(scene);
    std::size_t both_touch = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
        FingerInputs in;
        for (std::size_t finger = 0; finger < kFingers; ++finger)
            if (buttons[2 * i + finger] == 0) in[finger] = FingerInput{path_m[2 * i + finger]};
        fingers.tick(in, static_cast<std::uint32_t>(i * 1000));
        for (std::size_t finger = 0; finger < kFingers; ++finger)
            ASSERT_TRUE(same(records[i].tick[finger], fingers.output(finger))) << "tick " << i << " of " << finger;
        both_touch +=
            records[i].tick[0].state == HAPTABLE_CONTACT && records[i].tick[1].state == HAPTABLE_CONTACT ? 1 : 0;
        if (body == nullptr) continue;
        // With nobody there it rests, and the session's is the tick's before.
        if (!in[0] && !in[1]) continue;
        ASSERT_TRUE(same_bits(records[i].centre_m, fingers.state().touched()->position_m)) << i;
        ASSERT_TRUE(same_bits(records[i].turn, fingers.state().touched()->turn)) << i;
    }
    EXPECT_GT(both_touch, body != nullptr ? 20U : 500U);
    if (body != nullptr) {
        const auto& centre_m = records.back().centre_m;
        EXPECT_GT(std::hypot(centre_m[0] - 0.015F, centre_m[1] - 0.015F), 1e-3F) << "they push it about";
    }
}

// Bytes that are no model: cut, or naming a function that there is not.
TEST(ModelInBrowser, IsRefusedWhereItIsDamaged) {
    if (const std::string why = missing_servo(); !why.empty()) GTEST_SKIP() << why;
    haptable_model model = body_of_modes("cube", ForceLaw::kInterpolated).model();
    const std::string whole = model_bytes(model);
    const auto opens = [](const std::string& bytes) {
        return browser()
            .evaluate("WebAssembly.instantiate(module, {}).then(instance => { const model = " + js_bytes(bytes) +
                      "; return instance.exports.page_model(kept(instance.exports)(model), model.length) !== 0; })")
            .get<bool>();
    };
    EXPECT_TRUE(opens(whole));
    EXPECT_FALSE(opens(whole.substr(0, whole.size() / 2)));
    EXPECT_FALSE(opens(whole + "more"));
    std::string other = whole;
    model.check = model.check == nullptr ? haptable_check_crc : nullptr;
    const std::string unlike = model_bytes(model);
    const auto check = std::mismatch(other.begin(), other.end(), unlike.begin()).first;  // names a function
    *check = 77;
    EXPECT_FALSE(opens(other));
}

}  // namespace
}  // namespace haptable::test
