// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/summary.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <type_traits>

#include "host/base/file.hpp"
#include "host/base/program.hpp"

namespace haptable {

namespace {

/// XXH3 over values in a fixed order. Every list is preceded by its length, so that no two contents write alike.
class Hash {
public:
    Hash() : state_(XXH3_createState()) { XXH3_64bits_reset(state_); }
    ~Hash() { XXH3_freeState(state_); }
    Hash(const Hash&) = delete;
    Hash& operator=(const Hash&) = delete;

    template <typename T>
    void add(std::span<const T> values) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, double>);
        const std::uint64_t count = values.size();
        XXH3_64bits_update(state_, &count, sizeof count);
        XXH3_64bits_update(state_, values.data(), values.size_bytes());
    }
    void add(const std::string& text) { add(std::span<const char>(text)); }
    void add(const Material& material) {
        add(material.young_pa);
        add(material.poisson);
    }
    void add(double value) { add(std::span<const double>(&value, 1)); }
    std::uint64_t digest() const { return XXH3_64bits_digest(state_); }

private:
    XXH3_state_t* state_;
};

template <typename Pairs>
nlohmann::ordered_json to_object(const Pairs& pairs) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const auto& [key, value] : pairs) object[key] = value;
    return object;
}

nlohmann::ordered_json counts(const Body& body) {
    return {{"nodes", body.mesh.position_m.size()},
            {"surface_nodes", body.surface.node.size()},
            {"free_surface_nodes", body.free_surface_node.size()},
            {"surface_patches", body.surface.patch.size()},
            {"tetrahedra", body.mesh.tet.size()},
            {"fixed_nodes", body.fixed_count()},
            {"touchable_nodes", body.touch_node.size()},
            {"touchable_patches", body.touch_patch.size()}};
}

nlohmann::ordered_json checks(const Checks& checks) {
    return {{"largest_residual", checks.largest_residual},
            {"largest_block_difference", checks.largest_block_difference},
            {"largest_column_difference", checks.largest_column_difference},
            {"solved_nodes", checks.solved_nodes},
            {"largest_asymmetry", checks.largest_asymmetry},
            {"smallest_eigenvalue_m_per_n", checks.smallest_eigenvalue_m_per_n},
            {"largest_block_condition", checks.largest_block_condition},
            {"condition_estimate", checks.condition_estimate},
            {"smallest_pivot_ratio", checks.smallest_pivot_ratio}};
}

Checks read_checks(const nlohmann::json& json) {
    Checks checks;
    json.at("largest_residual").get_to(checks.largest_residual);
    json.at("largest_block_difference").get_to(checks.largest_block_difference);
    json.at("largest_column_difference").get_to(checks.largest_column_difference);
    json.at("solved_nodes").get_to(checks.solved_nodes);
    json.at("largest_asymmetry").get_to(checks.largest_asymmetry);
    json.at("smallest_eigenvalue_m_per_n").get_to(checks.smallest_eigenvalue_m_per_n);
    json.at("largest_block_condition").get_to(checks.largest_block_condition);
    json.at("condition_estimate").get_to(checks.condition_estimate);
    const nlohmann::json& pivot = json.at("smallest_pivot_ratio");
    checks.smallest_pivot_ratio = pivot.is_null() ? NAN : pivot.get<double>();  // MUMPS does not tell
    return checks;
}

/// XXH3 of this program's own bytes: a tool that was built anew may compute otherwise.
std::string program_hash() {
    Hash hash;
    hash.add(read_file("/proc/self/exe"));
    return fmt::format("{:016x}", hash.digest());
}

nlohmann::ordered_json to_json(const Material& material) {
    return {{"young_pa", material.young_pa}, {"poisson", material.poisson}};
}

nlohmann::ordered_json regions(const Scene& scene, const Body& body) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (std::size_t r = 0; r < scene.regions.size(); ++r) {
        nlohmann::ordered_json region = to_json(scene.regions[r].material);
        if (!scene.regions[r].where.group.empty()) region["group"] = scene.regions[r].where.group;
        region["tetrahedra"] = std::count(body.region.begin(), body.region.end(), static_cast<std::int32_t>(r));
        list.push_back(region);
    }
    return list;
}

nlohmann::ordered_json flash(const ModelSize& size) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    std::size_t sum = 0;
    for (const TableBytes& table : size.flash) {
        json["table"][table.name] = table.bytes;
        sum += table.bytes;
    }
    json["bytes"] = sum;
    for (const PrecisionError& p : size.precision)
        json["precision"][p.precision] = {
            {"bytes", p.bytes}, {"worst_force_error", p.worst}, {"mean_force_error", p.mean}};
    return json;
}

nlohmann::ordered_json memory(const Summary& summary) {
    const MemoryNeed& need = summary.memory;
    return {{"foreseen_bytes", need.peak()},
            {"stiffness_bytes", need.stiffness},
            {"factor_bytes", need.factor},
            {"inversion_bytes", need.fronts},
            {"mask_bytes", need.pairs},
            {"columns_bytes", need.columns},
            {"checks_bytes", need.solves},
            {"peak_bytes", summary.peak_bytes.empty() ? 0.0 : summary.peak_bytes.back().second},
            {"peak_bytes_by_stage", to_object(summary.peak_bytes)}};
}

/// What two runs must have in common for one to stand in for the other.
nlohmann::ordered_json identity(const Scene& scene, const Summary& summary) {
    return {{"name", scene.name},
            {"scene", scene.file.filename().string()},
            {"model_hash", fmt::format("{:016x}", summary.model_hash)},
            {"haptable_version", kVersion},
            {"program", program_hash()},
            {"tolerance", summary.tolerance},
            {"column_tolerance", summary.column_tolerance},
            {"drawing", summary.drawing}};
}

/// CPU seconds of all threads of this process.
double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) * 1024.0;
}

/// summary.json of a folder, where it and all files that it names are as they were written.
std::optional<nlohmann::json> read_intact(const std::filesystem::path& folder) {
    if (!std::filesystem::exists(folder / "summary.json")) return {};
    auto json = nlohmann::json::parse(read_file(folder / "summary.json"), nullptr, false);
    if (!json.is_object() || !json.contains("bytes") || !json["bytes"].is_object() || !json.contains("hash")) return {};
    for (const auto& [file, bytes] : json["bytes"].items()) {
        std::error_code missing;
        if (bytes != std::filesystem::file_size(folder / file, missing) || missing) return {};
    }
    for (const auto& [file, hash] : json["hash"].items())
        if (hash != hash_file(folder / file)) return {};
    return json;
}

std::string human_bytes(std::uintmax_t bytes) {
    if (bytes < 10'000) return fmt::format("{} B", bytes);
    if (bytes < 10'000'000) return fmt::format("{:.1f} kB", static_cast<double>(bytes) / 1e3);
    return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string flash_table(const Scene& scene, const ModelSize& size) {
    std::string text = "\n  flash of the servo       bytes    stored as      bytes   force error: worst    mean\n";
    std::size_t sum = 0;
    for (std::size_t i = 0; i < std::max(size.flash.size(), size.precision.size()); ++i) {
        text += i < size.flash.size() ? fmt::format("  {:<22} {:>8}", size.flash[i].name, size.flash[i].bytes)
                                      : std::string(33, ' ');
        if (i < size.flash.size()) sum += size.flash[i].bytes;
        if (i < size.precision.size()) {
            const PrecisionError& p = size.precision[i];
            text += fmt::format("    {:<10} {:>9}          {:>9.2g} {:>9.2g}{}", p.precision, p.bytes, p.worst, p.mean,
                                p.precision == scene.tables.precision ? "  (chosen)" : "");
        }
        text += '\n';
    }
    return text + fmt::format("  {:<22} {:>8}\n", "all", sum);
}

}  // namespace

StageClock::StageClock(Summary& summary)
    : summary_(summary), begin_(std::chrono::steady_clock::now()), cpu_begin_s_(cpu_seconds()) {}

void StageClock::end(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    const double cpu_s = cpu_seconds();
    summary_.time_s.emplace_back(stage, std::chrono::duration<double>(now - begin_).count());
    summary_.cpu_s.emplace_back(stage, cpu_s - cpu_begin_s_);
    summary_.peak_bytes.emplace_back(stage, peak_memory());
    begin_ = now;
    cpu_begin_s_ = cpu_s;
}

std::string hash_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return {};
    XXH3_state_t* state = XXH3_createState();
    XXH3_64bits_reset(state);
    std::vector<char> piece(std::size_t{1} << 20U);
    while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0)
        XXH3_64bits_update(state, piece.data(), static_cast<std::size_t>(file.gcount()));
    const std::uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return fmt::format("{:016x}", hash);
}

std::uint64_t hash_body(const Scene& scene, const Body& body) {
    Hash hash;
    hash.add(std::string(kVersion));
    for (const Eigen::Vector3d& p : body.mesh.position_m) hash.add(std::span<const double>(p.data(), 3));
    hash.add(std::span<const Tet>(body.mesh.tet));
    hash.add(std::span<const std::int32_t>(body.unknown));  // -1 marks the held nodes
    hash.add(std::span<const std::int32_t>(body.region));
    hash.add(scene.material);
    for (const Region& region : scene.regions) hash.add(region.material);
    return hash.digest();
}

std::uint64_t hash_work(const Scene& scene, const Summary& summary, std::span<const std::int32_t> node,
                        std::span<const std::int32_t> row) {
    Hash hash;
    hash.add(identity(scene, summary).dump());
    hash.add(summary.column_precision);
    hash.add(summary.column_unit_m_per_n);
    hash.add(node);
    hash.add(row);
    return hash.digest();
}

std::uint64_t hash_model(const Scene& scene, const Body& body) {
    Hash hash;
    hash.add(std::string(kVersion));
    for (const Eigen::Vector3d& p : body.mesh.position_m) hash.add(std::span<const double>(p.data(), 3));
    hash.add(std::span<const Tet>(body.mesh.tet));
    hash.add(std::span<const std::int32_t>(body.unknown));  // -1 marks the held nodes
    hash.add(std::span<const Patch>(body.touch_patch));
    hash.add(std::span<const std::int32_t>(body.region));
    hash.add(scene.material);
    for (const Region& region : scene.regions) hash.add(region.material);
    hash.add(scene.contact.force);
    hash.add(scene.contact.god_object);
    hash.add(scene.contact.rigid_stiffness_n_per_m);
    const ContactOptions& c = scene.contact;
    // Only where chosen: the hash of a scene without them is what it was.
    for (const auto& [name, value] : {std::pair{"mask_radius", c.mask_radius_m},
                                      {"friction", c.static_friction},
                                      {"kinetic_friction", c.kinetic_friction},
                                      {"release_slew", c.release_n_per_ms},
                                      {"coupling", c.coupling_n_per_m},
                                      {"auto coupling", c.auto_coupling ? 1.0 : 0.0},
                                      {"passivity", c.passivity ? 1.0 : 0.0}}) {
        if (value == 0.0) continue;
        hash.add(std::string(name));
        hash.add(value);
    }
    if (c.auto_coupling)
        for (double value : {scene.device.damping_n_s_per_m, scene.device.friction_n, scene.device.encoder_step_m})
            hash.add(value);
    hash.add(scene.device.max_force_n);
    hash.add(scene.tables.columns);
    hash.add(scene.tables.column_precision);
    hash.add(scene.tables.precision);
    if (!scene.tables.display_rows.empty()) {
        hash.add(std::span<const std::int32_t>(scene.tables.display_rows));
        hash.add(scene.tables.display_precision);
    }
    return hash.digest();
}

bool is_current(const std::filesystem::path& folder, const Scene& scene, const Summary& expected) {
    const auto old = read_intact(folder);
    if (!old) return false;
    const nlohmann::json wanted = identity(scene, expected);
    for (const auto& [key, value] : wanted.items())
        if (!old->contains(key) || (*old)[key] != value) return false;
    return true;
}

bool restore(const std::filesystem::path& folder, Summary& summary) try {
    const auto old = read_intact(folder);
    if (!old || old->value("body_hash", "") != fmt::format("{:016x}", summary.body_hash) ||
        old->value("program", "") != program_hash())
        return false;
    summary.tolerance = old->at("tolerance").get<double>();
    summary.column_tolerance = old->at("column_tolerance").get<double>();
    summary.drawing = old->at("drawing").get<std::string>();
    summary.threads = old->at("threads").get<int>();
    summary.checks = read_checks(old->at("checks"));
    const nlohmann::json &factor = old->at("factor"), &blocks = old->at("blocks"), &columns = old->at("columns");
    summary.ordering = factor.at("ordering").get<std::string>();
    summary.fill = factor.at("fill").get<double>();
    summary.flops = factor.at("flops").get<double>();
    summary.block_method = blocks.at("method").get<std::string>();
    summary.block_precision = blocks.at("precision").get<std::string>();
    summary.block_flops = blocks.at("flops").get<double>();
    summary.column_precision = columns.at("precision").get<std::string>();
    summary.float_column_error = columns.at("float_error").get<double>();
    summary.column_format = columns.at("format").get<std::string>();
    summary.column_unit_m_per_n = columns.at("unit_m_per_n").get<double>();
    summary.column_flops = columns.at("flops").get<double>();
    return true;
} catch (const nlohmann::json::exception&) {
    return false;
}

nlohmann::ordered_json to_json(const std::vector<Hold>& holds) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Hold& hold : holds)
        list.push_back({{"nodes", hold.nodes},
                        {"tetrahedra", hold.tets},
                        {"held_nodes", hold.held_nodes},
                        {"held", hold.is_held}});
    return list;
}

namespace {

/// What was chosen beyond the paper's contact.
void add_options(const ContactOptions& c, nlohmann::ordered_json& json) {
    if (c.static_friction > 0.0) json["friction"] = {{"static", c.static_friction}, {"kinetic", c.kinetic_friction}};
    if (c.release_n_per_ms > 0.0) json["release_n_per_ms"] = c.release_n_per_ms;
    if (c.passivity) json["passivity"] = true;
    if (c.auto_coupling) json["coupling"] = "auto";
    if (c.coupling_n_per_m > 0.0) json["coupling"] = c.coupling_n_per_m;
}

}  // namespace

std::string to_json(const Scene& scene, const Body& body, const Summary& summary) {
    nlohmann::ordered_json json = identity(scene, summary);
    json["body_hash"] = fmt::format("{:016x}", summary.body_hash);
    json["reused"] = summary.reused;
    json["reused_blocks"] = summary.reused_blocks;
    json["reused_columns"] = summary.reused_columns;
    if (!summary.rank_cpu_s.empty()) json["resumed_columns"] = summary.resumed_columns;
    json["threads"] = summary.threads;
    json["counts"] = counts(body);
    json["mesh"] = to_json(summary.audit);
    json["mesh"]["body"] = to_json(summary.holds);
    json["material"] = to_json(scene.material);
    if (!scene.regions.empty()) json["regions"] = regions(scene, body);
    json["contact"] = {{"force", scene.contact.force},
                       {"god_object", scene.contact.god_object},
                       {"rigid_stiffness_n_per_m", scene.contact.rigid_stiffness_n_per_m}};
    add_options(scene.contact, json["contact"]);
    if (scene.contact.mask_radius_m > 0.0)
        json["contact"]["mask"] = {{"radius_m", scene.contact.mask_radius_m},
                                   {"most_nodes", summary.mask_most_nodes},
                                   {"pairs", summary.mask_pairs},
                                   {"method", summary.mask_method},
                                   {"flops", summary.mask_flops},
                                   {"widened", summary.mask_widened},
                                   {"places", summary.mask_places}};
    json["device"] = {{"max_force_n", scene.device.max_force_n},
                      {"damping_n_s_per_m", scene.device.damping_n_s_per_m},
                      {"friction_n", scene.device.friction_n},
                      {"encoder_step_m", scene.device.encoder_step_m}};
    if (summary.size.stiffness.largest_n_per_m > 0.0)
        json["stiffness"] = {{"largest_n_per_m", summary.size.stiffness.largest_n_per_m},
                             {"stable_n_per_m", summary.size.stiffness.stable_n_per_m},
                             {"coupling_n_per_m", summary.size.stiffness.coupling_n_per_m},
                             {"felt_n_per_m", summary.size.stiffness.felt_n_per_m}};
    json["tables"] = {{"precision", scene.tables.precision},
                      {"columns", scene.tables.columns},
                      {"flash_budget", scene.tables.flash_budget}};
    if (!scene.tables.display_rows.empty()) {
        json["tables"]["display_rows"] = scene.tables.display_rows;
        json["tables"]["display_precision"] = scene.tables.display_precision;
    }
    json["flash"] = flash(summary.size);
    json["index"] = {{"boxes", summary.size.index.boxes},
                     {"fast_way_boxes", summary.size.index.fast_way_boxes},
                     {"tick_boxes", HAPTABLE_TICK_BOXES}};
    json["checks"] = checks(summary.checks);
    json["factor"] = {{"ordering", summary.ordering}, {"fill", summary.fill}, {"flops", summary.flops}};
    json["blocks"] = {
        {"method", summary.block_method}, {"precision", summary.block_precision}, {"flops", summary.block_flops}};
    json["columns"] = {{"precision", summary.column_precision}, {"float_error", summary.float_column_error},
                       {"format", summary.column_format},       {"unit_m_per_n", summary.column_unit_m_per_n},
                       {"flops", summary.column_flops},         {"flops_done", summary.column_flops_done}};
    json["memory"] = memory(summary);
    if (!summary.rank_cpu_s.empty())
        json["ranks"] = {{"count", summary.rank_cpu_s.size()},
                         {"cpu_s", summary.rank_cpu_s},
                         {"peak_bytes", summary.rank_peak_bytes}};
    json["bytes"] = to_object(summary.bytes);
    json["hash"] = to_object(summary.hashes);
    json["time_s"] = to_object(summary.time_s);
    json["cpu_s"] = to_object(summary.cpu_s);
    json["notes"] = body.mesh.notes;
    return json.dump(2) + "\n";
}

std::string to_table(const Scene& scene, const Body& body, const Summary& summary) {
    const Checks& c = summary.checks;
    std::string text = fmt::format("{} (model {:016x})\n", scene.name, summary.model_hash) + to_table(summary.audit);
    text +=
        fmt::format("  held {} nodes; free on the surface {}; touchable: {} free nodes, {} patches\n",
                    body.fixed_count(), body.free_surface_node.size(), body.touch_node.size(), body.touch_patch.size());
    for (std::size_t r = 0; r < scene.regions.size(); ++r)
        text += fmt::format("  region of line {}: {} tetrahedra, {:g} Pa, Poisson's ratio {:g}\n",
                            scene.regions[r].where.line,
                            std::count(body.region.begin(), body.region.end(), static_cast<std::int32_t>(r)),
                            scene.regions[r].material.young_pa, scene.regions[r].material.poisson);
    if (scene.contact.mask_radius_m > 0.0)
        text += fmt::format(
            "  pressure mask of {:g} m: at most {} nodes; at {} of {} vertices and edges the mesh is coarser, "
            "and the patch's own nodes carry the load\n",
            scene.contact.mask_radius_m, summary.mask_most_nodes, summary.mask_widened, summary.mask_places);
    const ServoStiffness& k = summary.size.stiffness;
    text += fmt::format("  largest stiffness of any point {:.3g} N/m; the device renders {:.3g} N/m stably{}\n",
                        k.largest_n_per_m, k.stable_n_per_m,
                        k.coupling_n_per_m > 0.0
                            ? fmt::format("; with a coupling of {:.3g} N/m in series {:.3g} N/m are felt",
                                          k.coupling_n_per_m, k.felt_n_per_m)
                        : k.largest_n_per_m > k.stable_n_per_m ? ": consider coupling = \"auto\" in [contact]"
                                                               : "");
    text += fmt::format("  spatial index: {} boxes, of which a finger's way of 5 mm visits at most {}; a tick {}\n",
                        summary.size.index.boxes, summary.size.index.fast_way_boxes, HAPTABLE_TICK_BOXES);
    text += "\n  check                                        value\n";
    const auto check = [&](const char* name, double value) { text += fmt::format("  {:<40} {:>9.3g}\n", name, value); };
    check("largest ||K x - b|| / ||b||", c.largest_residual);
    check("largest difference of L_ii to solves", c.largest_block_difference);
    check("largest difference of columns to solves", c.largest_column_difference);
    check("largest asymmetry of L", c.largest_asymmetry);
    check("smallest eigenvalue of any L_ii (m/N)", c.smallest_eigenvalue_m_per_n);
    check("largest condition of any L_ii", c.largest_block_condition);
    check("condition of K, estimated", c.condition_estimate);
    if (!std::isnan(c.smallest_pivot_ratio)) check("smallest pivot / diagonal of K", c.smallest_pivot_ratio);
    if (summary.drawing == "solves")
        text +=
            "\n  columns.npy would be over tables.column_budget: the factor is kept, and the viewer solves each "
            "frame\n";
    if (summary.reused) text += "\n  blocks, columns and checks are those of an earlier run of the same body\n";
    text += flash_table(scene, summary.size);
    text += ("\n  table                size    stage           time\n");
    for (std::size_t i = 0; i < std::max(summary.bytes.size(), summary.time_s.size()); ++i) {
        if (i < summary.bytes.size())
            text += fmt::format("  {:<14} {:>10}", summary.bytes[i].first, human_bytes(summary.bytes[i].second));
        else
            text += fmt::format("{:28}", "");
        if (i < summary.time_s.size())
            text += fmt::format("    {:<10} {:>9.4f} s", summary.time_s[i].first, summary.time_s[i].second);
        text += '\n';
    }
    return text;
}

}  // namespace haptable
