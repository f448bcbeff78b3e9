// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/pair.hpp"

#include <algorithm>
#include <array>
#include <mutex>

namespace haptable {

namespace {

constexpr std::size_t kChunk = 64;

/// The pair behind the one finger that a judge steps. A judge takes a plain function: what that knows is a thread's.
struct Behind {
    const haptable_pair_model* tables = nullptr;
    const Stroke* other = nullptr;
    int finger = 0;  ///< that is judged
    std::size_t tick = 0;
    haptable_room room{};
    haptable_pair& pair = room.fingers;
    PairTally* tally = nullptr;
};
thread_local Behind behind;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void count(const haptable_output out[2]) {
    const int contacts = haptable_touches(out[0].state) + haptable_touches(out[1].state);
    ++behind.tally->ticks;
    behind.tally->contact_ticks += contacts > 0 ? 1U : 0U;
    behind.tally->both_ticks += contacts == 2 ? 1U : 0U;
    if (contacts == 2 && behind.pair.touches[0] != behind.pair.touches[1]) ++behind.tally->left_ticks;
}

/// As haptable_servo_step, for the judged finger: the other one is at its own stroke's tick.
void step_both(const haptable_model* model, haptable_servo* servo, const float finger_m[3], std::uint32_t now_us,
               haptable_output* out) {
    if (model->god_object != behind.tables->model->god_object) /* the judge asks what one finger would do */
        return haptable_servo_step(model, servo, finger_m, now_us, out);
    const std::array<float, 3>& other = (*behind.other)[std::min(behind.tick++, behind.other->size() - 1)];
    float positions_m[2][3];
    std::copy_n(finger_m, 3, positions_m[behind.finger]);
    std::copy_n(other.begin(), 3, positions_m[1 - behind.finger]);
    haptable_output both[2];
    behind.pair.servo[behind.finger] = *servo;
    behind.pair.servo[behind.finger].finger = static_cast<std::uint8_t>(behind.finger);
    haptable_pair_step(behind.tables, &behind.pair, positions_m[0], positions_m[1], now_us, both);
    *servo = behind.pair.servo[behind.finger];
    servo->finger = 0;
    *out = both[behind.finger];
    count(both);
}

void judge_one(const TouchedByTwo& by, const StrokeMaker& maker, std::uint64_t seed, std::uint64_t number,
               PairTally& tally) {
    const Stroke own = maker.make(seed, 2 * number), other = maker.make(seed, 2 * number + 1);
    behind.tables = &by.pair;
    behind.other = &other;
    behind.finger = static_cast<int>(number % 2);
    behind.tick = 0;
    behind.tally = &tally;
    haptable_pair_init(&by.pair, &behind.pair);
    Touched touched = by.touched;
    touched.step = step_both;
    const Verdict verdict = judge(touched, own);
    ++tally.strokes;
    const bool outside = verdict.has(Fault::kOutside), lost = verdict.has(Fault::kLost);
    const bool force = verdict.has(Fault::kForce);
    tally.outside += outside ? 1U : 0U;
    tally.lost += lost ? 1U : 0U;
    tally.force += force ? 1U : 0U;
    if (outside || lost || force) tally.broken.push_back(number);
}

}  // namespace

void PairTally::add(const PairTally& more) {
    strokes += more.strokes;
    ticks += more.ticks;
    contact_ticks += more.contact_ticks;
    both_ticks += more.both_ticks;
    left_ticks += more.left_ticks;
    outside += more.outside;
    lost += more.lost;
    force += more.force;
    broken.insert(broken.end(), more.broken.begin(), more.broken.end());
}

PairTally run_pairs(const TouchedByTwo& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                    Workers& workers, const std::function<void(std::size_t done)>& on_done) {
    std::vector<PairTally> chunks((count + kChunk - 1) / kChunk);
    std::mutex mutex;
    std::size_t done = 0;
    workers.for_each(chunks.size(), [&](std::size_t chunk, int) {
        const std::size_t end = std::min(count, (chunk + 1) * kChunk);
        for (std::size_t number = chunk * kChunk; number < end; ++number)
            judge_one(touched, maker, seed, number, chunks[chunk]);
        const std::lock_guard lock(mutex);
        on_done(done += end - chunk * kChunk);
    });
    PairTally all;
    for (const PairTally& chunk : chunks) all.add(chunk);
    return all;
}

}  // namespace haptable
