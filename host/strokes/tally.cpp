// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/tally.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

constexpr std::size_t kLongBehind = 20;  // ticks

/// The counts by the names that they have in a file.
template <typename Visit>
void for_each_count(const Visit& visit) {
    visit("strokes", &Tally::strokes);
    visit("ticks", &Tally::ticks);
    visit("contact_ticks", &Tally::contact_ticks);
    visit("both_ticks", &Tally::both_ticks);
    visit("limits", &Tally::limits);
    visit("clamped_strokes", &Tally::clamped);
    visit("behind_strokes", &Tally::behind);
    visit("long_behind_strokes", &Tally::long_behind);
    visit("passed_motions", &Tally::passed);
}

Tally tally_of(const nlohmann::ordered_json& json) {
    Tally tally;
    for_each_count([&](const char* name, std::size_t Tally::*count) { json.at(name).get_to(tally.*count); });
    json.at("most_given").get_to(tally.most_given);
    json.at("most_area").get_to(tally.most_area);
    json.at("cpu_s").get_to(tally.cpu_s);
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
    for_each_count([&](const char*, std::size_t Tally::*count) { this->*count += other.*count; });
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += other.faulty[f];
    most_given = std::max(most_given, other.most_given);
    most_area = std::max(most_area, other.most_area);
    cpu_s += other.cpu_s;
    broken.insert(broken.end(), other.broken.begin(), other.broken.end());
}

Tally sum_of(const std::vector<Tally>& tallies) {
    Tally sum;
    for (const Tally& tally : tallies) sum.add(tally);
    return sum;
}

nlohmann::ordered_json to_json(const Tally& tally) {
    nlohmann::ordered_json json;
    for_each_count([&](const char* name, std::size_t Tally::*count) { json[name] = tally.*count; });
    json["most_given"] = tally.most_given;
    json["most_area"] = tally.most_area;
    json["cpu_s"] = tally.cpu_s;
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
