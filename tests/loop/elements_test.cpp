// SPDX-License-Identifier: GPL-2.0-or-later
// Every element from its scene over a session to its picture, by the programs and parts that a user runs.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/base/json.hpp"
#include "host/base/modes.hpp"
#include "host/device/session.hpp"
#include "host/servo/servo.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/session.hpp"
#include "host/view/deformation.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// Of the deformed surface, m.
double largest_displacement(const fs::path& vtu) {
    const std::string text = read_file(vtu);
    const std::size_t begin = text.find('>', text.find("Name=\"displacement_m\"")) + 1;
    std::istringstream numbers(text.substr(begin, text.find('<', begin) - begin));
    double largest = 0.0;
    for (double x = 0.0; numbers >> x;) largest = std::max(largest, std::abs(x));
    return largest;
}

/// A servo program of tables in memory, as a process of its own: a child of this one, with its command line.
class ServoProcess {
public:
    ServoProcess(const ServoScene& scene, std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "servo");
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        std::fflush(nullptr);  // or the child would write it again
        id_ = fork();
        if (id_ != 0) return;
        prctl(PR_SET_PDEATHSIG, SIGKILL);  // it does not outlive the test
        std::_Exit(servo_main(static_cast<int>(argv.size()), argv.data(), scene));
    }
    ~ServoProcess() {
        if (id_ > 0) end(SIGKILL);
    }
    ServoProcess(const ServoProcess&) = delete;
    ServoProcess& operator=(const ServoProcess&) = delete;

    void kill(int signal) const { ::kill(id_, signal); }
    int wait_for_exit() { return end(0); }

private:
    int end(int signal) {
        int status = 0;
        ::kill(id_, signal);
        waitpid(std::exchange(id_, 0), &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    pid_t id_ = 0;
};

class ElementLoop : public testing::TestWithParam<Element> {
protected:
    /// Tables of the paper's cube, or of one with as many nodes, under a force.
    fs::path precompute(const std::string& contact) const {
        const fs::path scene = folder / "scene.toml", tables = folder / "tables";
        write_file(scene,
                   fmt::format("name = \"cube\"\n[mesh]\nelement = \"{}\"\ngenerate = \"cube\"\nnodes_per_side = {}\n"
                               "[material]\nyoung = 1e4\npoisson = 0.49\n[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n"
                               "[contact]\n{}",
                               word(GetParam()), GetParam() == Element::kQuadratic ? 4 : 7, contact));
        EXPECT_EQ(run(fmt::format("{} {} -o {} --quiet", program("haptable-precompute").string(), scene.string(),
                                  tables.string()))
                      .status,
                  0);
        return tables;
    }
    WorkFolder folder;
};

TEST_P(ElementLoop, ASessionWithLeastEnergyFromFirstTouchToThePicture) {
    const fs::path in = precompute("force = \"pressure-mask\"\nmask_radius = 0.006\ngod_object = \"least-energy\"\n");
    const Tables tables = read_tables(in);
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    const std::vector<std::uint32_t> node(servo.node.begin(), servo.node.end());
    const ServoScene scene{&model, node.data(), "cube"};
    // 1. Servo and device in lockstep.
    Connection connection("memq://");
    const auto path = scripted_path("poke,drag,circle", PathOptions{});
    ServoRecord record(scene, folder / "felt.csv");
    const PointDevice device(Device{}, Hand{}, path->at(0.0).position_m);
    SessionOptions options;
    options.lockstep = true;
    LocalStepper stepper(scene);
    Session session(stepper, connection, &record);
    const DeviceReport report = DeviceSession(device, *path, connection, options, nullptr).run();
    record.finish();
    EXPECT_EQ(report.missed + report.foreign_answers, 0);
    EXPECT_GT(report.contact_ticks, 800);
    // 2. What the finger gave on its way in and got on its way out: a passive body keeps some or none.
    const auto rows = read_rows(folder / "felt.csv");
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(report.ticks));
    EXPECT_EQ(rows.front()[4] + rows.back()[4], 0.0);
    double given = 0.0, stored = 0.0, largest_n = 0.0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        for (std::size_t a = 0; a < 3; ++a)
            given -= 0.5 * (rows[i][14 + a] + rows[i - 1][14 + a]) * (rows[i][1 + a] - rows[i - 1][1 + a]);
        stored = std::max(stored, given);
        largest_n = std::max(largest_n, std::hypot(rows[i][14], rows[i][15], rows[i][16]));
    }
    EXPECT_GT(largest_n, 0.1);
    EXPECT_GT(given, -1e-3 * stored);
    // 3. The picture and the meshes for ParaView.
    std::size_t pressed = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) pressed = rows[i][16] > rows[pressed][16] ? i : pressed;
    const auto view = [&](const std::string& more) {
        return run(fmt::format("{} {} --csv {} --ticks {} --quiet {}", program("haptable-view").string(), in.string(),
                               (folder / "felt.csv").string(), pressed, more));
    };
    const Outcome picture = view(fmt::format("-o {}", (folder / "cube.png").string()));
    ASSERT_EQ(picture.status, 0) << picture.err;
    EXPECT_GT(fs::file_size(folder / "cube.png"), 20'000U);
    const Outcome meshes = view(fmt::format("--vtu -o {}", (folder / "vtu").string()));
    ASSERT_EQ(meshes.status, 0) << meshes.err;
    EXPECT_GT(largest_displacement(folder / "vtu/frame_000000.vtu"), 0.001);
}

// Servo, device and viewer as processes, over LCM's own UDP. The session goes on until the viewer has its pictures.
TEST_P(ElementLoop, ServoDeviceAndViewerAsProcessesOverUdp) {
    const std::string url = own_url();
    setenv("LCM_DEFAULT_URL", url.c_str(), 1);
    if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    const fs::path in = precompute("force = \"pressure-mask\"\nmask_radius = 0.006\n");
    const Tables tables = read_tables(in);
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    const std::vector<std::uint32_t> node(servo.node.begin(), servo.node.end());
    const ServoScene scene{&model, node.data(), "cube"};
    ServoProcess serving(scene, {"--lcm", "--no-realtime", "--quiet", "--csv", (folder / "servo.csv").string()});
    Process device({program("haptable-device").string(), (folder / "scene.toml").string(), "--tables", in.string(),
                    "--lockstep", "--path", "poke,drag", "--seconds", "86400", "--no-realtime", "--quiet", "--csv",
                    (folder / "device.csv").string()});
    const Outcome viewer = run(fmt::format("{} {} --lcm --frames 40 --seconds 60 --size 320x240 --json --quiet -o {}",
                                           program("haptable-view").string(), in.string(), (folder / "out").string()));
    device.kill(SIGTERM);
    EXPECT_EQ(device.wait_for_exit(), 0);
    serving.kill(SIGTERM);
    EXPECT_EQ(serving.wait_for_exit(), 0);
    unsetenv("LCM_DEFAULT_URL");
    // 1. What was seen is the session's: none of its messages left out, a body that was pressed.
    ASSERT_EQ(viewer.status, 0) << viewer.err;
    const auto seen = parse_json(viewer.out);
    EXPECT_EQ(seen.at("frames"), 40);
    EXPECT_EQ(seen.at("left_out_messages"), 0);
    EXPECT_TRUE(fs::exists(folder / "out/frame_000039.png"));
    const auto rows = read_rows(folder / "servo.csv"), device_rows = read_rows(folder / "device.csv");
    double largest_n = 0.0;
    for (const auto& row : rows) largest_n = std::max(largest_n, std::hypot(row[14], row[15], row[16]));
    EXPECT_GT(seen.at("largest_force_n").get<double>(), 0.02);
    EXPECT_LE(seen.at("largest_force_n").get<double>(), largest_n * (1.0 + 4.0 * kFloat));
    EXPECT_GT(seen.at("largest_displacement_mm").get<double>(), 0.2);
    // 2. What the device got is what the servo gave, but for the tick that its end cut short.
    ASSERT_GT(device_rows.size(), 1000U);
    ASSERT_GE(rows.size() + 1, device_rows.size());
    for (std::size_t i = 0; i + 1 < device_rows.size(); ++i)
        for (std::size_t a = 0; a < 3; ++a)
            ASSERT_EQ(static_cast<float>(rows[i][14 + a]), static_cast<float>(device_rows[i][10 + a])) << i;
    // 3. And what the same path gives without any session.
    write_file(folder / "path.csv", finger_path_of(folder / "servo.csv"));
    ServoProcess replay(
        scene, {"--quiet", "--replay", (folder / "path.csv").string(), "--out", (folder / "replay.csv").string()});
    ASSERT_EQ(replay.wait_for_exit(), 0);
    EXPECT_TRUE(read_file(folder / "replay.csv") == read_file(folder / "servo.csv"));
}

// With the consistent force the surface as it is drawn, flat between its nodes, meets the finger.
TEST_P(ElementLoop, TheDrawnSurfaceMeetsTheFinger) {
    const fs::path in = precompute("force = \"consistent\"\n");
    const Tables tables = read_tables(in);
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    Deformation deformation(tables, in);
    haptable_servo state;
    haptable_servo_init(&state);
    check_tables(model, state);
    haptable_output out{};
    int checked = 0;
    for (int tick = 0; tick < 400; ++tick) {
        const float x[3] = {0.009F + 3e-5F * float(tick), 0.011F + 1e-5F * float(tick), tick == 0 ? 0.0305F : 0.029F};
        haptable_servo_step(&model, &state, x, 0, &out);
        if (out.patch == HAPTABLE_NONE || tick % 20 != 19) continue;
        std::vector<NodalForce> loads;
        Vector3d moved = Vector3d::Zero(), u;
        for (int c = 0; c < 3; ++c) {
            const float* f = out.nodal_force_n[c];
            loads.push_back({static_cast<std::int32_t>(servo.node[out.vertex[c]]), {f[0], f[1], f[2]}});
            u[c] = double(x[c]) - double(out.god_object_m[c]);
        }
        const auto displaced = deformation.displace(loads);
        for (int c = 0; c < 3; ++c) {
            const auto row = std::lower_bound(tables.row_id.begin(), tables.row_id.end(), loads[std::size_t(c)].node) -
                             tables.row_id.begin();
            for (int a = 0; a < 3; ++a) moved[a] += double(out.alpha[c]) * double(displaced[std::size_t(3 * row + a)]);
        }
        EXPECT_WITHIN((moved - u).norm() / u.norm(), .count = 64, .epsilon = kFloat, .condition = 10.0);
        ++checked;
    }
    EXPECT_GT(checked, 10);
}

INSTANTIATE_TEST_SUITE_P(All, ElementLoop,
                         testing::Values(Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic),
                         [](const auto& given) {
                             std::string name = word(given.param);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

}  // namespace
}  // namespace haptable::test
