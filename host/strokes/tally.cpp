// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/tally.hpp"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

constexpr std::size_t kLongBehind = 20;  // ticks

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
    visit("most_given", &Tally::most_given, most);
    visit("most_area", &Tally::most_area, most);
    visit("cpu_s", &Tally::cpu_s, sum);
}

Tally tally_of(const nlohmann::ordered_json& json) {
    Tally tally;
    for_each_number([&](const char* name, auto number, const auto&) { json.at(name).get_to(tally.*number); });
    for (std::size_t f = 0; f < kFaults; ++f) json.at("faults").at(std::string(kFaultNames[f])).get_to(tally.faulty[f]);
    for (const nlohmann::ordered_json& one : json.at("broken")) {
        Broken& broken = tally.broken.emplace_back();
        one.at("stroke").get_to(broken.number);
        one.at("ticks").get_to(broken.verdict.tick);
    }
    return tally;
}

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
    if (!verdict.clamped && verdict.most_stored_j > 0.0)
        most_given = std::max(most_given, verdict.most_given_j / verdict.most_stored_j);
    if (!verdict.is_clean()) broken.push_back({number, verdict});
}

void Tally::add(const Tally& other) {
    for_each_number(
        [&](const char*, auto number, const auto& join) { this->*number = join(this->*number, other.*number); });
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += other.faulty[f];
    broken.insert(broken.end(), other.broken.begin(), other.broken.end());
}

Tally sum_of(const std::vector<Tally>& tallies) {
    Tally sum;
    for (const Tally& tally : tallies) sum.add(tally);
    return sum;
}

nlohmann::ordered_json to_json(const Tally& tally) {
    nlohmann::ordered_json json;
    for_each_number([&](const char* name, auto number, const auto&) { json[name] = tally.*number; });
    for (std::size_t f = 0; f < kFaults; ++f) json["faults"][std::string(kFaultNames[f])] = tally.faulty[f];
    json["broken"] = nlohmann::ordered_json::array();
    for (const Broken& broken : tally.broken)
        json["broken"].push_back({{"stroke", broken.number}, {"ticks", broken.verdict.tick}});
    return json;
}

void write_tally(const std::filesystem::path& file, const std::string& key, const Tally& tally) {
    nlohmann::ordered_json json = to_json(tally);
    json["key"] = key;
    std::filesystem::create_directories(file.parent_path());
    write_file(file, json_text(json, 1) + "\n");
}

std::optional<Tally> read_tally(const std::filesystem::path& file, const std::string& key) try {
    if (!std::filesystem::exists(file)) return {};
    const nlohmann::ordered_json json = nlohmann::ordered_json::parse(read_file(file));
    if (json.at("key") != key) return {};
    return tally_of(json);
} catch (const nlohmann::ordered_json::exception& error) {
    throw Error(file.string() + ": holds no counts: " + error.what() + "; remove it to stroke again");
}

}  // namespace haptable
