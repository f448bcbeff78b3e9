// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"
#include "host/base/process_cost.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kChunk = 64;
constexpr std::size_t kLongBehind = 20;  // ticks
constexpr std::size_t kExamples = 3;     // of each fault, body and mode

// ---- counts, and the files that keep them --------------------------------------------------------------------------

/// The numbers by the names that they have in a file, and how two of them become one.
template <typename Visit>
void for_each_number(const Visit& visit) {
    const std::plus<> sum;
    const auto most = [](double a, double b) { return std::max(a, b); };
    visit("strokes", &Tally::strokes, sum);
    visit("ticks", &Tally::ticks, sum);
    visit("contact_ticks", &Tally::contact_ticks, sum);
    visit("both_ticks", &Tally::both_ticks, sum);
    visit("limits", &Tally::limits, sum);
    visit("clamped_strokes", &Tally::clamped, sum);
    visit("behind_strokes", &Tally::behind, sum);
    visit("long_behind_strokes", &Tally::long_behind, sum);
    visit("passed_motions", &Tally::passed, sum);
    visit("most_area", &Tally::most_area, most);
    visit("cpu_s", &Tally::cpu_s, sum);
}

ordered_json to_json(const Tally& tally) {
    ordered_json json;
    for_each_number([&](const char* name, auto number, const auto&) { json[name] = tally.*number; });
    for (std::size_t f = 0; f < kFaults; ++f) json["faults"][std::string(kFaultNames[f])] = tally.faulty[f];
    json["broken"] = ordered_json::array();
    for (const Broken& broken : tally.broken)
        json["broken"].push_back({{"stroke", broken.number}, {"ticks", broken.verdict.tick}});
    return json;
}

Tally tally_of(const ordered_json& json) {
    Tally tally;
    for_each_number([&](const char* name, auto number, const auto&) { json.at(name).get_to(tally.*number); });
    for (std::size_t f = 0; f < kFaults; ++f) json.at("faults").at(std::string(kFaultNames[f])).get_to(tally.faulty[f]);
    for (const ordered_json& one : json.at("broken")) {
        Broken& broken = tally.broken.emplace_back();
        one.at("stroke").get_to(broken.number);
        one.at("ticks").get_to(broken.verdict.tick);
    }
    return tally;
}

/// What was kept there under that key, of all that counts depend on; none where there is no such file, or one of
/// another key. Throws Error that names the file where it is damaged.
std::optional<Tally> read_tally(const fs::path& file, const std::string& key) try {
    if (!fs::exists(file)) return {};
    const ordered_json json = ordered_json::parse(read_file(file));
    if (json.at("key") != key) return {};
    return tally_of(json);
} catch (const ordered_json::exception& error) {
    throw Error(file.string() + ": holds no counts: " + error.what() + "; remove it to stroke again");
}

// ---- the strokes of a campaign -------------------------------------------------------------------------------------

/// Of each word the mode with this name, or all modes whose names contain it; all without words.
std::vector<TouchMode> modes_of(const std::vector<std::string>& words) {
    const std::vector<TouchMode> all = all_modes();
    const auto is_meant = [&](const TouchMode& mode, const std::string& word) {
        const bool is_whole = std::ranges::count(all, word, &TouchMode::name) > 0;
        return is_whole ? mode.name() == word : mode.name().find(word) != std::string::npos;
    };
    std::vector<TouchMode> modes;
    std::ranges::copy_if(all, std::back_inserter(modes), [&](const TouchMode& mode) {
        return words.empty() || std::ranges::any_of(words, [&](const auto& word) { return is_meant(mode, word); });
    });
    if (modes.empty())
        throw Error(
            "--mode: no mode has that in its name; they are interpolated-nearest, "
            "consistent-least-energy-friction-two-free-rings and so on");
    return modes;
}

/// Each mode of each body has strokes of its own.
std::uint64_t seed_of(std::uint64_t seed, const std::string& body, const TouchMode& mode) {
    std::uint64_t hash = seed * 0x100000001b3U;
    for (char c : body + "/" + mode.name()) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;  // FNV-1a
    return hash;
}

class Campaign {
public:
    explicit Campaign(const CampaignOptions& options)
        : options_(options),
          progress_(options.quiet),
          workers_(options.threads > 0 ? options.threads
                                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
          program_(hash_file("/proc/self/exe")),
          modes_(modes_of(options.modes)) {}

    ordered_json run() {
        progress_.stage("reading meshes");
        StrokedMeshes meshes =
            collect_meshes(options_.places, options_.meshes, options_.most_nodes, options_.folder / "meshes");
        left_out_ = std::move(meshes.left_out);
        std::size_t tallies = 0;
        for (const StrokedMesh& mesh : meshes.taken) {
            std::set<std::string> told;
            for (const TouchMode& mode : modes_) {
                const auto [name, why] = refusal(mesh, mode);
                if (name.empty())
                    ++tallies;
                else if (told.insert(name).second)
                    left_out_.push_back({mesh.name + ", " + name, why});
            }
        }
        if (tallies == 0) {
            std::string why;
            for (const LeftOut& one : left_out_) why += fmt::format("; {}: {}", one.name, one.why);
            throw Error("no mesh to stroke: " +
                        (why.empty() ? "give scenes, meshes or folders of them" : "all are left out" + why));
        }
        each_ = std::max<std::size_t>(1, options_.strokes / tallies);
        all_ = each_ * tallies;
        progress_.stage("strokes");
        ordered_json modes, bodies, left_out = ordered_json::array();
        for (const StrokedMesh& mesh : meshes.taken) bodies.push_back(stroke(mesh));
        progress_.clear();
        for (const TouchMode& mode : modes_)
            modes.push_back({{"name", mode.name()},
                             {"force", word(mode.force)},
                             {"god_object", word(mode.god_object)},
                             {"friction", mode.friction},
                             {"fingers", mode.fingers},
                             {"tool", mode.tool},
                             {"free", mode.body.motion > 0},
                             {"rings", mode.body.rings}});
        for (const LeftOut& one : left_out_) left_out.push_back({{"name", one.name}, {"why", one.why}});
        return {{"seed", options_.seed},    {"taken_over_strokes", taken_over_},
                {"total", to_json(total_)}, {"modes", modes},
                {"bodies", bodies},         {"left_out", left_out}};
    }

private:
    /// By what a mesh is not touched, and why; empty where it is.
    LeftOut refusal(const StrokedMesh& mesh, const TouchMode& mode) const {
        const bool is_mask = mode.force == ForceLaw::kPressureMask;
        if (is_mask && mesh.nodes > options_.most_mask_nodes)
            return {"by masks",
                    fmt::format("{} nodes, more than {} (--most-mask-nodes)", mesh.nodes, options_.most_mask_nodes)};
        if (mode.is_coupled() && mesh.coupling_bytes(mode.force) > options_.most_coupling)
            return {is_mask ? "by masks of two" : "by two",
                    fmt::format("{:.0f} MB couple two places, more than {:.0f} (--most-coupling)",
                                1e-6 * static_cast<double>(mesh.coupling_bytes(mode.force)),
                                1e-6 * static_cast<double>(options_.most_coupling))};
        if (mode.body.motion > 0 && mesh.parts > 1)
            return {"free", fmt::format("{} parts, which nothing holds together", mesh.parts)};
        return {};
    }

    /// One body after the other, held before free; those of one kind share their tables. Without strokes are the modes
    /// that it was not touched in.
    ordered_json stroke(const StrokedMesh& mesh) {
        std::vector<Tally> tally(modes_.size());
        BodyTables tables(mesh.scene, options_.folder / "tables" / mesh.name);
        for (const BodyKind& kind : kBodyKinds) try {
                for (const ForceLaw force : every<ForceLaw>()) stroke(mesh, kind, force, tables, tally);
            } catch (const Error& error) {
                left_out_.push_back({mesh.name + kind.name(), error.what()});
            }
        ordered_json modes;
        for (std::size_t m = 0; m < modes_.size(); ++m) {
            modes[modes_[m].name()] = to_json(tally[m]);
            total_.add(tally[m]);
        }
        return {{"name", mesh.name},
                {"filled", mesh.filled},
                {"nodes", mesh.nodes},
                {"tables_cpu_s", tables.cpu_s()},
                {"modes", modes}};
    }

    void stroke(const StrokedMesh& mesh, const BodyKind& kind, ForceLaw force, BodyTables& tables,
                std::vector<Tally>& tally) {
        std::vector<std::size_t> chosen;
        TouchMode most{force, GodObject::kNearest, false, 1, kind};
        for (std::size_t m = 0; m < modes_.size(); ++m) {
            const TouchMode& mode = modes_[m];
            if (mode.force != force || !(mode.body == kind) || !refusal(mesh, mode).name.empty()) continue;
            chosen.push_back(m);
            if (mode.is_coupled()) most.fingers = HAPTABLE_FINGERS;
        }
        std::optional<StrokedBody> body;
        for (const std::size_t m : chosen) {
            const TouchMode& mode = modes_[m];
            tell(0, mesh.name + ", tables");
            auto kept = read_tally(counts_file(mesh, mode), key_of(mesh, mode));
            if (!kept && !body) body.emplace(tables.with(most));
            if (kept) taken_over_ += kept->strokes;
            tally[m] = kept ? std::move(*kept) : stroke(mesh, *body, mode);
        }
    }

    fs::path counts_file(const StrokedMesh& mesh, const TouchMode& mode) const {
        return options_.folder / "counts" / fmt::format("{}-{}-{}.json", mesh.name, mode.name(), options_.seed);
    }

    /// All that the counts depend on.
    std::string key_of(const StrokedMesh& mesh, const TouchMode& mode) const {
        Hash hash;
        hash.add(program_);
        hash.add(mesh.identity);
        hash.add(to_toml(in_mode(mesh.scene, mode)));
        hash.add(fmt::format("{} {}", options_.seed, each_));
        return hash.text();
    }

    /// The time left is that of what this run counts itself.
    void tell(std::size_t done, const std::string& what) {
        const double own = static_cast<double>(std::max<std::size_t>(1, all_ - taken_over_));
        progress_.done(static_cast<double>(done_ + done) / own, what);
    }

    Tally stroke(const StrokedMesh& mesh, const StrokedBody& body, const TouchMode& mode) {
        const Scene scene = in_mode(mesh.scene, mode);
        const auto tools = mode.tool ? random_tools(body, scene) : std::vector<ToolTables>{};
        const StrokedModel model(body, scene.contact, tools);
        const std::uint64_t seed = seed_of(options_.seed, mesh.name, mode);
        const std::string what = mesh.name + ", " + mode.name();
        Tally tally = run_strokes(model.touched(), seed, each_, workers_, [&](std::size_t done) { tell(done, what); });
        done_ += each_;
        for (std::size_t f = 0; f < kFaults; ++f) {
            std::size_t left = kExamples;
            for (const Broken& broken : tally.broken) {
                if (broken.verdict.tick[f] < 0 || left == 0) continue;
                --left;
                const Touched touched = model.touched().of_stroke(broken.number);
                Scene own = scene;
                own.contact.fingers = touched.fingers();
                if (mode.tool) {
                    const ToolTables& tool = tools[broken.number % tools.size()];
                    own.tool = Tool{tool.point_m, {}, tool.max_torque_n_m};
                }
                write_example(static_cast<Fault>(f), touched, own, make_stroke(touched, seed, broken.number),
                              fmt::format("{}-{}-{}-{}", mesh.name, mode.name(), options_.seed, broken.number));
            }
        }
        ordered_json json = to_json(tally);
        json["key"] = key_of(mesh, mode);
        fs::create_directories(options_.folder / "counts");
        write_file(counts_file(mesh, mode), json_text(json, 1) + "\n");
        return tally;
    }

    /// A stroke with that fault, shrunk, beside its scene.
    void write_example(Fault fault, const Touched& touched, const Scene& scene, const Stroke& stroke,
                       const std::string& name) {
        const Stroke least = shrink(touched, stroke, fault);
        const fs::path folder = options_.folder / "faults" / fmt::format("{}-{}", name_of(fault), name);
        fs::create_directories(folder);
        write_file(folder / "scene.toml", to_toml(scene));
        write_file(folder / "stroke.csv", to_csv(least, touched.tool() != nullptr ? kToolHand : touched.fingers()));
        if (options_.quiet) return;
        progress_.clear();
        fmt::print("{}: {} ticks, {} at the last\n", folder.string(), least.size(), name_of(fault));
    }

    const CampaignOptions& options_;
    Progress progress_;
    Workers workers_;
    std::string program_;
    std::vector<TouchMode> modes_;  ///< [m]
    std::vector<LeftOut> left_out_;
    std::size_t each_ = 0, all_ = 0, done_ = 0;
    std::size_t taken_over_ = 0;  ///< strokes that an earlier run had counted
    Tally total_;
};

}  // namespace

void Tally::add(std::uint64_t number, const Stroke& stroke, const Verdict& verdict) {
    ++strokes;
    ticks += stroke.size();
    contact_ticks += verdict.contact_ticks;
    both_ticks += verdict.both_ticks;
    most_area = std::max(most_area, verdict.most_area);
    clamped += verdict.clamped ? 1 : 0;
    behind += verdict.most_behind_ticks > 0 ? 1 : 0;
    long_behind += verdict.most_behind_ticks > kLongBehind ? 1 : 0;
    passed += verdict.passed;
    limits += verdict.limits;
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += verdict.tick[f] >= 0 ? 1 : 0;
    if (!verdict.is_clean()) broken.push_back({number, verdict});
}

void Tally::add(const Tally& other) {
    for_each_number(
        [&](const char*, auto number, const auto& join) { this->*number = join(this->*number, other.*number); });
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += other.faulty[f];
    broken.insert(broken.end(), other.broken.begin(), other.broken.end());
}

Tally run_strokes(const Touched& touched, std::uint64_t seed, std::size_t count, Workers& workers,
                  const std::function<void(std::size_t done)>& on_done) {
    const double cpu_begin_s = process_cost().cpu_s;
    std::vector<Tally> chunks((count + kChunk - 1) / kChunk);
    std::mutex mutex;
    std::size_t done = 0;
    workers.for_each(chunks.size(), [&](std::size_t chunk, int) {
        const std::size_t end = std::min(count, (chunk + 1) * kChunk);
        for (std::size_t number = chunk * kChunk; number < end; ++number) {
            const Touched one = touched.of_stroke(number);
            const Stroke stroke = make_stroke(one, seed, number);
            chunks[chunk].add(number, stroke, judge(one, stroke));
        }
        const std::lock_guard lock(mutex);
        on_done(done += end - chunk * kChunk);
    });
    Tally all;
    for (const Tally& chunk : chunks) all.add(chunk);
    all.cpu_s = process_cost().cpu_s - cpu_begin_s;
    return all;
}

ordered_json run_campaign(const CampaignOptions& options) { return Campaign(options).run(); }

}  // namespace haptable
