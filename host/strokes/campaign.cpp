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
#include "host/base/process_cost.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunk = 64;

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

/// The strokes of a campaign, one body after the other.
class Campaign {
public:
    Campaign(const CampaignOptions& options, Progress& progress,
             const std::function<void(const std::string& line)>& told)
        : options_(options),
          progress_(progress),
          told_(told),
          workers_(options.threads > 0 ? options.threads
                                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
          program_(hash_file("/proc/self/exe")) {}

    CampaignResult run() {
        result_.seed = options_.seed;
        result_.modes = modes_of(options_.modes);
        progress_.stage("reading meshes");
        const StrokedMeshes meshes =
            collect_meshes(options_.places, options_.meshes, options_.most_nodes, options_.folder / "meshes");
        result_.left_out = meshes.left_out;
        std::size_t tallies = 0;
        for (const StrokedMesh& mesh : meshes.taken) {
            std::set<std::string> told;
            for (const TouchMode& mode : result_.modes) {
                const auto [name, why] = refusal(mesh, mode);
                if (name.empty())
                    ++tallies;
                else if (told.insert(name).second)
                    result_.left_out.push_back({mesh.name + ", " + name, why});
            }
        }
        if (tallies == 0) {
            std::string why;
            for (const LeftOut& one : result_.left_out) why += fmt::format("; {}: {}", one.name, one.why);
            throw Error("no mesh to stroke: " +
                        (why.empty() ? "give scenes, meshes or folders of them" : "all are left out" + why));
        }
        each_ = std::max<std::size_t>(1, options_.strokes / tallies);
        all_ = each_ * tallies;
        progress_.stage("strokes");
        for (const StrokedMesh& mesh : meshes.taken) stroke(mesh);
        progress_.clear();
        return result_;
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

    /// One body after the other, held before free; those of one kind share their tables.
    void stroke(const StrokedMesh& mesh) {
        StrokedMeshResult one{mesh, std::vector<Tally>(result_.modes.size()), 0.0};
        BodyTables tables(mesh.scene, options_.folder / "tables" / mesh.name);
        for (const BodyKind& kind : kBodyKinds) try {
                for (const ForceLaw force : every<ForceLaw>()) stroke(mesh, kind, force, tables, one.tally);
            } catch (const Error& error) {
                result_.left_out.push_back({mesh.name + kind.name(), error.what()});
            }
        one.tables_cpu_s = tables.cpu_s();
        result_.results.push_back(std::move(one));
    }

    void stroke(const StrokedMesh& mesh, const BodyKind& kind, ForceLaw force, BodyTables& tables,
                std::vector<Tally>& tally) {
        std::vector<std::size_t> chosen;
        TouchMode most{force, GodObject::kNearest, false, 1, kind};
        for (std::size_t m = 0; m < result_.modes.size(); ++m) {
            const TouchMode& mode = result_.modes[m];
            if (mode.force != force || !(mode.body == kind) || !refusal(mesh, mode).name.empty()) continue;
            chosen.push_back(m);
            if (mode.is_coupled()) most.fingers = HAPTABLE_FINGERS;
        }
        std::optional<StrokedBody> body;
        for (const std::size_t m : chosen) {
            const TouchMode& mode = result_.modes[m];
            tell(0, mesh.name + ", tables");
            auto kept = options_.again ? std::nullopt : read_tally(counts_file(mesh, mode), key_of(mesh, mode));
            if (!kept && !body) body.emplace(tables.with(most));
            if (kept) result_.taken_over += kept->strokes;
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
        const double own = static_cast<double>(std::max<std::size_t>(1, all_ - result_.taken_over));
        progress_.done(static_cast<double>(done_ + done) / own, what);
    }

    Tally stroke(const StrokedMesh& mesh, const StrokedBody& body, const TouchMode& mode) {
        const Scene scene = in_mode(mesh.scene, mode);
        const auto tools = mode.tool ? body.random_tools(scene) : std::vector<ToolTables>{};
        const StrokedModel model(body, scene.contact, tools);
        const StrokeMaker maker(body.servo());
        const std::uint64_t seed = seed_of(options_.seed, mesh.name, mode);
        const std::string what = mesh.name + ", " + mode.name();
        Tally tally =
            run_strokes(model.touched(), maker, seed, each_, workers_, [&](std::size_t done) { tell(done, what); });
        done_ += each_;
        for (std::size_t f = 0; f < kFaults; ++f) {
            std::size_t left = options_.examples;
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
                write_example(static_cast<Fault>(f), touched, own, make_stroke(touched, maker, seed, broken.number),
                              fmt::format("{}-{}-{}-{}", mesh.name, mode.name(), options_.seed, broken.number));
            }
        }
        write_tally(counts_file(mesh, mode), key_of(mesh, mode), tally);
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
        told_(fmt::format("{}: {} ticks, {} at the last", folder.string(), least.size(), name_of(fault)));
    }

    const CampaignOptions& options_;
    Progress& progress_;
    const std::function<void(const std::string& line)>& told_;
    Workers workers_;
    std::string program_;
    std::size_t each_ = 0, all_ = 0, done_ = 0;
    CampaignResult result_;
};

}  // namespace

Tally run_strokes(const Touched& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                  Workers& workers, const std::function<void(std::size_t done)>& on_done) {
    const double cpu_begin_s = process_cost().cpu_s;
    std::vector<Tally> chunks((count + kChunk - 1) / kChunk);
    std::mutex mutex;
    std::size_t done = 0;
    workers.for_each(chunks.size(), [&](std::size_t chunk, int) {
        const std::size_t end = std::min(count, (chunk + 1) * kChunk);
        for (std::size_t number = chunk * kChunk; number < end; ++number) {
            const Touched one = touched.of_stroke(number);
            const Stroke stroke = make_stroke(one, maker, seed, number);
            chunks[chunk].add(number, stroke, judge(one, stroke));
        }
        const std::lock_guard lock(mutex);
        on_done(done += end - chunk * kChunk);
    });
    Tally all = sum_of(chunks);
    all.cpu_s = process_cost().cpu_s - cpu_begin_s;
    return all;
}

Tally CampaignResult::total() const {
    Tally sum;
    for (const StrokedMeshResult& one : results) sum.add(one.total());
    return sum;
}

CampaignResult run_campaign(const CampaignOptions& options, Progress& progress,
                            const std::function<void(const std::string& line)>& told) {
    return Campaign(options, progress, told).run();
}

nlohmann::ordered_json to_json(const CampaignResult& result) {
    nlohmann::ordered_json json{{"seed", result.seed},
                                {"taken_over_strokes", result.taken_over},
                                {"total", to_json(result.total())},
                                {"modes", nlohmann::ordered_json::array()},
                                {"bodies", nlohmann::ordered_json::array()},
                                {"left_out", nlohmann::ordered_json::array()}};
    for (const TouchMode& mode : result.modes)
        json["modes"].push_back({{"name", mode.name()},
                                 {"force", word(mode.force)},
                                 {"god_object", word(mode.god_object)},
                                 {"friction", mode.friction},
                                 {"fingers", mode.fingers},
                                 {"tool", mode.tool},
                                 {"free", mode.body.motion > 0},
                                 {"rings", mode.body.rings}});
    for (const StrokedMeshResult& one : result.results) {
        nlohmann::ordered_json modes;
        for (std::size_t m = 0; m < result.modes.size(); ++m) modes[result.modes[m].name()] = to_json(one.tally[m]);
        json["bodies"].push_back({{"name", one.mesh.name},
                                  {"filled", one.mesh.filled},
                                  {"nodes", one.mesh.nodes},
                                  {"patches", one.mesh.patches},
                                  {"hinges", one.mesh.hinges},
                                  {"tables_cpu_s", one.tables_cpu_s},
                                  {"modes", modes}});
    }
    for (const LeftOut& left_out : result.left_out)
        json["left_out"].push_back({{"name", left_out.name}, {"why", left_out.why}});
    return json;
}

}  // namespace haptable
