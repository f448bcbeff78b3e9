// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/campaign.hpp"

#include <algorithm>
#include <mutex>

namespace haptable {

namespace {

constexpr std::size_t kChunk = 64;

}  // namespace

void Tally::add(std::uint64_t number, const Stroke& stroke, const Verdict& verdict) {
    ++strokes;
    ticks += stroke.size();
    contact_ticks += verdict.contact_ticks;
    clamped += verdict.clamped ? 1 : 0;
    limits += verdict.counters.walk_limits + verdict.counters.slide_limits + verdict.counters.box_limits;
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += verdict.tick[f] >= 0 ? 1 : 0;
    if (!verdict.clamped && verdict.most_stored_j > 0.0)
        most_given = std::max(most_given, verdict.most_given_j / verdict.most_stored_j);
    if (!verdict.is_clean()) broken.push_back({number, verdict});
}

void Tally::add(const Tally& other) {
    strokes += other.strokes;
    ticks += other.ticks;
    contact_ticks += other.contact_ticks;
    clamped += other.clamped;
    limits += other.limits;
    for (std::size_t f = 0; f < kFaults; ++f) faulty[f] += other.faulty[f];
    most_given = std::max(most_given, other.most_given);
    broken.insert(broken.end(), other.broken.begin(), other.broken.end());
}

Tally run_strokes(const Touched& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                  Workers& workers, const std::function<void(std::size_t done)>& on_done) {
    std::vector<Tally> chunks((count + kChunk - 1) / kChunk);
    std::mutex mutex;
    std::size_t done = 0;
    workers.for_each(chunks.size(), [&](std::size_t chunk, int) {
        const std::size_t end = std::min(count, (chunk + 1) * kChunk);
        for (std::size_t number = chunk * kChunk; number < end; ++number) {
            const Stroke stroke = maker.make(seed, number);
            chunks[chunk].add(number, stroke, judge(touched, stroke));
        }
        const std::lock_guard lock(mutex);
        on_done(done += end - chunk * kChunk);
    });
    Tally all;
    for (const Tally& chunk : chunks) all.add(chunk);
    return all;
}

}  // namespace haptable
