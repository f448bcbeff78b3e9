// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-run as a user starts it: a session in one command, and every way in which it can end before its time.
// Skipped where LCM has no multicast route (run these under scripts/loopback.sh) or the programs are not built.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/json.hpp"
#include "host/link/log_reader.hpp"
#include "host/target/image.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

class Run : public testing::Test {
protected:
    void SetUp() override {
        const std::string url = own_url();
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
        for (const std::string& needed :
             {run, (build_folder() / "cube/servo").string(), program("haptable-device").string()})
            if (!std::filesystem::exists(needed)) GTEST_SKIP() << needed << " is not built: make scene";
        if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }

    std::vector<std::string> command(std::initializer_list<std::string> more) const {
        std::vector<std::string> words{run, "meshes/cube.toml", "-o", (folder / "out").string(), "--no-realtime"};
        words.insert(words.end(), more);
        return words;
    }
    Process::Place place() const { return {{}, (folder / "stdout").string(), (folder / "stderr").string()}; }
    std::string said() const { return read_file(folder / "stderr"); }
    nlohmann::json summary() const { return parse_json(read_file(folder / "out/summary.json")); }

    /// Waits until the session has been recorded for a while.
    bool wait_for_record(std::uintmax_t bytes = 200'000) const {
        const auto give_up = Clock::now() + std::chrono::seconds(60);
        std::error_code none;
        while (Clock::now() < give_up) {
            const std::uintmax_t size = std::filesystem::file_size(folder / "out/session.lcmlog", none);
            if (!none && size >= bytes) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return false;
    }
    /// The record is one that other programs read: no half event, no half line.
    void expect_whole_record() const {
        LogReader log(folder / "out/session.lcmlog");
        std::size_t events = 0;
        while (log.next()) ++events;
        EXPECT_GT(events, 100U);
        EXPECT_EQ(log.damaged(), 0);
        for (const char* csv : {"servo.csv", "device.csv", "session.csv"}) {
            const std::string text = read_file(folder / "out" / csv);
            EXPECT_EQ(text.back(), '\n') << csv;
            EXPECT_GT(lines_of(text).size(), 20U) << csv;
        }
        EXPECT_NE(read_file(folder / "out/report.html").find("</html>"), std::string::npos);
    }
    /// The id of the program with these words in its command line that `parent` started; 0: none.
    static pid_t child_of(pid_t parent, const std::string& words) {
        for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
            std::ifstream status(entry.path() / "stat"), line(entry.path() / "cmdline");
            std::string text((std::istreambuf_iterator<char>(line)), {}), id, name, state;
            pid_t its_parent = 0;
            status >> id >> name >> state >> its_parent;
            if (its_parent == parent && text.find(words) != std::string::npos) return std::stoi(id);
        }
        return 0;
    }

    WorkFolder folder;
    std::string run = program("haptable-run");
};

TEST_F(Run, LeavesAFolderWithAllOfASession) {
    // A busy machine may keep the logger from its socket until that is full. What it lacks then is told; here a session
    // counts whose record is whole.
    for (int sessions = 0; sessions < 5; ++sessions) {
        Process process(command({"--path", "poke", "--draw", "nothing", "--lockstep", "--json"}), place());
        ASSERT_EQ(process.wait_for_exit(), 0) << said();
        EXPECT_EQ(read_file(folder / "stdout"), read_file(folder / "out/summary.json"));
        EXPECT_EQ(parse_json(read_file(folder / "out/device.json"))["ticks"],
                  parse_json(read_file(folder / "out/servo.json"))["ticks"]);
        if (summary()["unrecorded_ticks"] == 0) break;
    }
    ASSERT_EQ(summary()["unrecorded_ticks"], 0);
    expect_whole_record();
    EXPECT_EQ(summary()["trouble"], "none");
    EXPECT_EQ(summary()["unanswered"], 0);
    EXPECT_GT(summary()["contact_ticks"], 300);
    EXPECT_EQ(read_rows(folder / "out/servo.csv").size(), summary()["ticks"]);
    EXPECT_EQ(parse_json(read_file(folder / "out/device.json"))["ticks"], summary()["ticks"]);
    EXPECT_EQ(parse_json(read_file(folder / "out/servo.json"))["ticks"], summary()["ticks"]);
    // The log is a regression test: the servo gives the same again.
    const Outcome again =
        haptable::test::run((build_folder() / "cube/servo").string() + " --quiet --check --replay " +
                            (folder / "out/session.lcmlog").string() + " --out " + (folder / "again.csv").string());
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(read_file(folder / "again.csv"), read_file(folder / "out/servo.csv"));
    const std::string page = read_file(folder / "out/report.html");
    for (const char* title : {"Force on the finger", "Depth", "Energy", "Faults so far"})
        EXPECT_NE(page.find(title), std::string::npos) << title;
}

// A logger that is kept from its socket loses ticks, and the summary says how many.
TEST_F(Run, CountsTheTicksThatItsRecordLacks) {
    Process process(command({"--seconds", "600", "--draw", "nothing", "--lockstep"}), place());
    ASSERT_TRUE(wait_for_record()) << said();
    process.kill(SIGSTOP);
    std::this_thread::sleep_for(std::chrono::seconds(1));  // servo and device go on, by thousands of ticks
    process.kill(SIGCONT);
    ASSERT_TRUE(wait_for_record(10'000'000)) << said();
    process.kill(SIGINT);
    EXPECT_EQ(process.wait_for_exit(), 130);
    const std::size_t recorded = lines_of(read_file(folder / "out/session.csv")).size() - 1;
    EXPECT_GT(summary()["unrecorded_ticks"], 0);
    EXPECT_EQ(summary()["ticks"], recorded);
    const auto servos = parse_json(read_file(folder / "out/servo.json"))["ticks"].get<std::int64_t>();
    EXPECT_EQ(summary()["unrecorded_ticks"],
              servos - summary()["ticks"].get<std::int64_t>() + summary()["unanswered"].get<std::int64_t>());
}

// The summary says where the body is that the finger never met.
TEST_F(Run, SaysThatTheFingerNeverMetTheBody) {
    for (const char* at : {"0.1,0.1,0.1", "0.015,0.015,0.03"}) {
        Process process(command({"--path", "poke", "--draw", "nothing", "--lockstep", "--quiet", "--", "--at", at}),
                        place());
        ASSERT_EQ(process.wait_for_exit(), 0) << said();
        const bool misses = at[2] == '1';
        EXPECT_EQ(summary().value("never_met", ""),
                  misses ? "the touchable surface lies in (0 0 0) to (0.03 0.03 0.03) m" : "");
        EXPECT_EQ(summary()["contact_ticks"] == 0, misses);
    }
}

// What servo and device tell their user is beside the status lines, with its time, and in the report.
TEST_F(Run, ShowsWhatTheProgramsTell) {
    const std::string told = "m rejected, no force: it is not a number";
    for (const bool quiet : {false, true}) {
        std::vector<std::string> words =
            command({"--path", "poke", "--draw", "nothing", "--lockstep", "--fault", "nan=0.01", "--seed", "2"});
        if (quiet) words.emplace_back("--quiet");
        for (const char* file : {"stdout", "stderr"}) std::filesystem::remove(folder / file);
        Process process(words, place());
        ASSERT_EQ(process.wait_for_exit(), 0) << said();
        const std::vector<std::string> lines = lines_of(said());
        const auto with_time = [&](const std::string& line) {
            return line.find(" s  servo: position ") != std::string::npos && line.ends_with(told);
        };
        EXPECT_EQ(std::any_of(lines.begin(), lines.end(), with_time), !quiet) << said();
        EXPECT_EQ(lines.empty(), quiet) << said();
        // Its closing lines: the paper's point is not what most people want to feel.
        EXPECT_EQ(read_file(folder / "stdout").find("contact = { force = \"pressure-mask\"") == std::string::npos,
                  quiet);
        const std::string page = read_file(folder / "out/report.html");
        EXPECT_NE(page.find(" s</th><td>servo: position "), std::string::npos);
        EXPECT_NE(page.find(told + "</td>"), std::string::npos);
    }
}

// Live, the viewer listens before the device begins: a session in lockstep, over in some 50 ms, has a picture too.
TEST_F(Run, DrawsWhileItRuns) {
    for (const bool lockstep : {true, false}) {
        std::vector<std::string> words =
            command({"--path", "poke", "--seconds", "1", "--draw", "live", "--every", "400"});
        if (lockstep) words.emplace_back("--lockstep");
        Process process(words, place());
        ASSERT_EQ(process.wait_for_exit(), 0) << said();
        expect_whole_record();
        EXPECT_EQ(summary()["trouble"], "none");
        std::size_t pictures = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder / "out/pictures")) {
            if (entry.path().filename() == ".haptable") continue;
            EXPECT_EQ(read_file(entry.path()).substr(1, 3), "PNG") << entry.path();
            ++pictures;
        }
        EXPECT_GE(pictures, 1U);
        // One each 400 ms of the session's time, which a busy machine may stretch; not one each 33.
        EXPECT_LE(static_cast<double>(pictures), summary()["wall_s"].get<double>() / 0.4 + 2.0);
    }
}

// In real time, between programs: the report shows what the device was made to do.
TEST_F(Run, ShowsFaultsThatWereAskedFor) {
    Process process(
        command({"--seconds", "1", "--draw", "nothing", "--fault", "drop=0.2,gone=0.01:30ms", "--seed", "5"}), place());
    ASSERT_EQ(process.wait_for_exit(), 0) << said();
    expect_whole_record();
    // How many ticks a device in real time has is the machine's matter; that some were lost is the faults'. What is
    // published is answered: they lose messages within the device.
    const auto servo = parse_json(read_file(folder / "out/servo.json"));
    EXPECT_GT(servo["lost_states"], 0);
    EXPECT_GT(servo["silences"], 0);
    EXPECT_NE(read_file(folder / "out/report.html").find("lost_states"), std::string::npos);
}

TEST_F(Run, CtrlCLeavesAValidRecord) {
    Process process(command({"--seconds", "60", "--draw", "nothing"}), place());
    ASSERT_TRUE(wait_for_record()) << said();
    process.kill(SIGINT);
    EXPECT_EQ(process.wait_for_exit(), 130);
    expect_whole_record();
    EXPECT_EQ(summary()["trouble"], "ended by Ctrl-C");
}

TEST_F(Run, AServoThatDiesIsNamedAndLeavesAValidRecord) {
    Process process(command({"--seconds", "60", "--draw", "nothing", "--quiet"}), place());
    ASSERT_TRUE(wait_for_record()) << said();
    const pid_t servo = child_of(process.id(), "cube/servo");
    ASSERT_GT(servo, 0);
    ::kill(servo, SIGKILL);
    EXPECT_EQ(process.wait_for_exit(), 1);
    EXPECT_EQ(lines_of(said()).size(), 1U) << said();
    EXPECT_NE(said().find("servo was ended by signal 9 (Killed)"), std::string::npos) << said();
    expect_whole_record();
}

// What it said before its end is the reason that the user reads.
TEST_F(Run, ADeviceThatRefusesHasTheLastWord) {
    Process process(command({"--path", "no-such-path", "--draw", "nothing", "--quiet"}), place());
    EXPECT_EQ(process.wait_for_exit(), 1);
    EXPECT_NE(said().find("\"no-such-path\" is not known"), std::string::npos) << said();
}

// RLIMIT_FSIZE stands for the full disk: a write takes a part, and then none.
TEST_F(Run, AFullDiskIsSaidAndLeavesAValidRecord) {
    std::string words = "trap '' XFSZ; ulimit -f 500; exec";
    for (const std::string& word : command({"--seconds", "60", "--draw", "nothing", "--quiet"})) words += " " + word;
    Process process({"bash", "-c", words}, place());
    EXPECT_EQ(process.wait_for_exit(), 1);
    EXPECT_NE(said().find("session.lcmlog: cannot be written"), std::string::npos) << said();
    expect_whole_record();
}

// The same on a disk that is full, all files at once: a megabyte of memory, in a mount namespace.
TEST_F(Run, AFullTmpfsIsSaidAndLeavesAValidRecord) {
    if (haptable::test::run("unshare -rm mount -t tmpfs none /mnt").status != 0)
        GTEST_SKIP() << "no mount namespaces for this user: a disk of a megabyte cannot be tried";
    const std::string disk = (folder / "disk").string();
    std::filesystem::create_directory(disk);
    Process process({"unshare", "-rm", "sh", "-c",
                     "mount -t tmpfs -o size=1m none " + disk + "; " + run + " meshes/cube.toml -o " + disk +
                         "/out --no-realtime --lockstep --seconds 60 --draw nothing --quiet; status=$?; cp -r " + disk +
                         "/out " + folder.path().string() + "; exit $status"},
                    place());
    EXPECT_EQ(process.wait_for_exit(), 1);
    EXPECT_EQ(lines_of(said()).size(), 1U) << said();
    EXPECT_NE(said().find("cannot be written"), std::string::npos) << said();
    LogReader log(folder / "out/session.lcmlog");
    std::size_t events = 0;
    while (log.next()) ++events;
    EXPECT_GT(events, 100U);
    EXPECT_EQ(log.damaged(), 0);
    for (const char* csv : {"servo.csv", "device.csv"}) EXPECT_EQ(read_file(folder / "out" / csv).back(), '\n') << csv;
}

TEST_F(Run, KilledItLeavesNoProgramAndAValidLog) {
    Process process(command({"--seconds", "60", "--draw", "nothing", "--quiet"}), place());
    ASSERT_TRUE(wait_for_record()) << said();
    const pid_t servo = child_of(process.id(), "cube/servo"), device = child_of(process.id(), "haptable-device");
    ASSERT_GT(servo, 0);
    ASSERT_GT(device, 0);
    ::kill(process.id(), SIGKILL);
    const auto is_running = [](pid_t id) {
        std::ifstream stat("/proc/" + std::to_string(id) + "/stat");
        std::string word, state;
        return stat >> word >> word >> state && state != "Z";
    };
    for (int tries = 0; tries < 1000 && (is_running(servo) || is_running(device)); ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_FALSE(is_running(servo));
    EXPECT_FALSE(is_running(device));
    LogReader log(folder / "out/session.lcmlog");
    while (log.next()) {
    }
    EXPECT_EQ(log.damaged(), 0);
}

// One that was killed leaves no lock, and what it left is replaced.
TEST_F(Run, AfterAKilledOneTheFolderIsWrittenAgain) {
    {
        const Process killed(command({"--seconds", "60", "--draw", "nothing", "--quiet"}), place());
        ASSERT_TRUE(wait_for_record()) << said();
        ::kill(killed.id(), SIGKILL);
    }
    write_file(folder / "out/servo.csv.haptable-999999999", "half");
    Process again(command({"--seconds", "0.3", "--lockstep", "--draw", "nothing", "--quiet"}), place());
    ASSERT_EQ(again.wait_for_exit(), 0) << said();
    EXPECT_EQ(parse_json(read_file(folder / "out/device.json"))["ticks"], 300);
    EXPECT_FALSE(std::filesystem::exists(folder / "out/servo.csv.haptable-999999999"));
}

TEST_F(Run, TheSecondIntoAFolderIsTold) {
    Process first(command({"--seconds", "60", "--draw", "nothing", "--quiet"}), place());
    ASSERT_TRUE(wait_for_record()) << said();
    const std::string second = run + " meshes/cube.toml --seconds 0.1 --draw nothing -o " + (folder / "out").string();
    const Outcome outcome = haptable::test::run(second);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("out: process " + std::to_string(first.id()) + " is writing it"), std::string::npos)
        << outcome.err;
    first.kill(SIGINT);
    EXPECT_EQ(first.wait_for_exit(), 130) << said();
    expect_whole_record();
}

// A folder of pages with pictures, and one of tables: neither is a session's.
TEST_F(Run, FilesOfOthersStay) {
    std::filesystem::create_directories(folder / "out/pictures");
    write_file(folder / "out/pictures/a.png", "the user's");
    const auto refused = [&](const std::string& out) {
        return haptable::test::run(run + " meshes/cube.toml --seconds 0.1 --draw nothing -o " + out);
    };
    Outcome outcome = refused((folder / "out").string());
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("out: holds files that haptable did not write"), std::string::npos) << outcome.err;
    EXPECT_EQ(read_file(folder / "out/pictures/a.png"), "the user's");
    const std::string tables = (folder / "tables").string();
    ASSERT_EQ(
        haptable::test::run(program("haptable-precompute").string() + " meshes/cube.toml --quiet -o " + tables).status,
        0);
    const std::string before = read_file(folder / "tables/summary.json");
    outcome = refused(tables);
    EXPECT_NE(outcome.err.find("tables: holds haptable's tables, not session"), std::string::npos) << outcome.err;
    EXPECT_EQ(read_file(folder / "tables/summary.json"), before);
}

TEST_F(Run, ServesATargetInQemu) {
    const std::string missing = TargetImage(build_folder(), "cube", "cortex-m7").missing();
    if (!missing.empty()) GTEST_SKIP() << missing;
    Process process(command({"--path", "poke", "--target", "cortex-m7", "--lockstep", "--seconds", "0.3", "--draw",
                             "nothing", "--quiet"}),
                    place());
    ASSERT_EQ(process.wait_for_exit(), 0) << said();
    expect_whole_record();
    EXPECT_EQ(summary()["servo_on"], "cortex-m7");
    EXPECT_EQ(summary()["ticks"], 300);
    EXPECT_EQ(summary()["unanswered"], 0);
    EXPECT_FALSE(std::filesystem::exists(folder / "out/to-target"));
}

TEST_F(Run, AReplayOntoItsOwnInputIsAnError) {
    write_file(folder / "path.csv", "x,y,z\n0,0,1\n");
    const Outcome outcome = haptable::test::run((build_folder() / "cube/servo").string() + " --replay " +
                                                (folder / "path.csv").string() + " --out " + folder.path().string() +
                                                "/../" + folder.path().filename().string() + "/path.csv");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("is what --replay reads"), std::string::npos) << outcome.err;
    EXPECT_EQ(read_file(folder / "path.csv"), "x,y,z\n0,0,1\n");
}

// The record of a session is the path of the next, but not in the folder where it would be replaced.
TEST_F(Run, APathOutOfItsOwnFolderIsAnError) {
    const std::string text = "x,y,z\n0,0,1\n", name = (folder / "out/device.csv").string();
    std::filesystem::create_directory(folder / "out");
    write_file(name, text);
    for (const std::string& one :
         {program("haptable-device").string() + " meshes/cube.toml --path " + name + " --csv " + name,
          run + " meshes/cube.toml -o " + (folder / "out").string() + " --path " + name}) {
        const Outcome outcome = haptable::test::run(one);
        EXPECT_EQ(outcome.status, 1);
        EXPECT_NE(outcome.err.find("device.csv: is what --path reads"), std::string::npos) << outcome.err;
        EXPECT_EQ(read_file(name), text);
    }
}

// Away from haptable's folder there is no make: the command is said.
TEST_F(Run, ASceneWithoutAServoNamesTheCommand) {
    write_file(folder / "a.toml",
               "name = \"not-built\"\n[mesh]\ngenerate = \"cube\"\n[material]\nyoung = 1e4\npoisson = 0.3\n"
               "[[fixed]]\nbox = [-1.0, -1.0, -1.0, 1.0, 1.0, 1e-9]\n");
    Process::Place elsewhere = place();
    elsewhere.folder = folder.path();
    Process process({run, "a.toml", "-o", "out"}, elsewhere);
    EXPECT_EQ(process.wait_for_exit(), 1);
    EXPECT_NE(said().find("make scene SCENE=a.toml"), std::string::npos) << said();
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace
}  // namespace haptable::test
