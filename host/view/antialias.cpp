// SPDX-License-Identifier: GPL-2.0-or-later
// A horizontal edge that is not quite horizontal is a staircase: runs of n pixels with a step at each end. The straight
// edge is half a pixel off at a step and nothing in the run's middle: of the k-th pixel from the step it covers
//     integral from k to min(k + 1, n / 2) of (1/2 - d / n) dd
#include "host/view/antialias.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <future>

namespace haptable {

namespace {

constexpr int kLeast = 24;    // of 255: a difference of brightness that is an edge
constexpr int kLongest = 24;  // pixels that are looked along an edge, each way

int channel(std::uint32_t color, unsigned shift) { return static_cast<int>(color >> shift & 0xFFU); }

/// Share of the k-th pixel of a run of n, in 256ths.
int covered_256(int k, int n) {
    const float from = static_cast<float>(k), all = static_cast<float>(n);
    const float to = std::min(from + 1.0F, 0.5F * all);
    if (to <= from) return 0;
    return static_cast<int>(256.0F * (0.5F * (to - from) - (to * to - from * from) / (2.0F * all)));
}

int clamped(float v, int most) { return static_cast<int>(std::clamp(v, 0.0F, static_cast<float>(most))); }

/// 1 where a pixel differs from one of its four neighbours by an edge. In bytes, for the vector units.
void mark_edges(const std::uint8_t* row, std::size_t width, std::size_t count, std::uint8_t* is_edge) {
    const std::uint8_t *up = row - width, *down = row + width;
    for (std::size_t x = 0; x < count; ++x) {
        const std::uint8_t low = std::min(std::min(row[x - 1], row[x + 1]), std::min(up[x], down[x]));
        const std::uint8_t high = std::max(std::max(row[x - 1], row[x + 1]), std::max(up[x], down[x]));
        is_edge[x] = high - row[x] >= kLeast || row[x] - low >= kLeast ? 1 : 0;
    }
}

}  // namespace

void Smoothing::find_brightness(const Image& image) {
    brightness_.resize(image.pixel.size());
    const auto width = static_cast<std::size_t>(image.width);
    for (int y = std::max(top_ - 2, 0); y < std::min(bottom_ + 2, image.height); ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * width;
        for (std::size_t at = row; at < row + width; ++at) {
            const std::uint32_t c = image.pixel[at];
            brightness_[at] =
                static_cast<std::uint8_t>(((c >> 16U & 0xFFU) + 2U * (c >> 8U & 0xFFU) + (c & 0xFFU)) / 4U);
        }
    }
}

void Smoothing::mix(const Image& image, std::ptrdiff_t at, std::ptrdiff_t towards, int share_256, Mixes& mixes) {
    const std::uint32_t here = image.pixel[static_cast<std::size_t>(at)];
    const std::uint32_t there = image.pixel[static_cast<std::size_t>(towards)];
    std::uint32_t out = 0;
    for (unsigned shift = 0; shift < 24; shift += 8) {
        const int a = channel(here, shift), b = channel(there, shift);
        out |= static_cast<std::uint32_t>(a + ((b - a) * share_256 + 128) / 256) << shift;
    }
    mixes.push_back({static_cast<std::size_t>(at), out});
}

/// Smooths a pixel's edge to the neighbour that differs most: along is the way along the edge, across the way over
/// it. The edge goes on while both sides stay as they are; where it ends, a step to the other side counts.
void Smoothing::look_at(const Image& image, int x, int y, Mixes& mixes) const {
    const std::ptrdiff_t width = image.width, at = static_cast<std::ptrdiff_t>(y) * width + x;
    const int here = brightness(at);
    const int up = std::abs(brightness(at - width) - here), down = std::abs(brightness(at + width) - here);
    const int left = std::abs(brightness(at - 1) - here), right = std::abs(brightness(at + 1) - here);
    const int vertical = std::max(up, down), horizontal = std::max(left, right);
    if (std::max(vertical, horizontal) < kLeast) return;
    const bool lies = vertical >= horizontal;
    const std::ptrdiff_t across = lies ? (up > down ? -width : width) : (left > right ? -1 : 1);
    const std::ptrdiff_t along = lies ? 1 : width;
    const int room[2] = {lies ? x - 1 : y - 1, lies ? image.width - 2 - x : image.height - 2 - y};
    const int there = brightness(at + across), middle = (here + there) / 2, half = std::abs(there - here) / 2;
    int length[2];
    bool comes_over[2];  // at its end, the other side's colour comes over to ours
    for (int end = 0; end < 2; ++end) {
        const std::ptrdiff_t step = end == 0 ? -along : along;
        const int most = std::min(room[end], kLongest);
        int n = 0, mean = middle;
        while (n < most) {
            ++n;
            const std::ptrdiff_t p = at + n * step;
            mean = (brightness(p) + brightness(p + across)) / 2;
            if (std::abs(mean - middle) * 2 >= half) break;
        }
        length[end] = n;
        comes_over[end] = std::abs(mean - middle) * 2 >= half && (mean < middle) == (there < here);
    }
    const int nearer = length[0] <= length[1] ? 0 : 1;
    if (!comes_over[nearer]) return;
    const int share_256 = covered_256(length[nearer] - 1, length[0] + length[1] - 1);
    if (share_256 > 0) mix(image, at, at + across, share_256, mixes);
}

void Smoothing::look_at_rows(const Image& image, int from, int to, Mixes& mixes) const {
    mixes.clear();
    const auto width = static_cast<std::size_t>(image.width);
    const auto left = static_cast<std::size_t>(left_), count = static_cast<std::size_t>(right_ - left_);
    std::vector<std::uint8_t> is_edge(count + sizeof(std::uint64_t), 0);
    for (int y = from; y < to; ++y) {
        const std::uint8_t* row = brightness_.data() + static_cast<std::size_t>(y) * width + left;
        mark_edges(row, width, count, is_edge.data());
        for (std::size_t word = 0; word < count; word += sizeof(std::uint64_t)) {
            std::uint64_t any = 0;
            std::memcpy(&any, is_edge.data() + word, sizeof(any));
            if (any == 0) continue;
            for (std::size_t x = word; x < std::min(word + sizeof(any), count); ++x)
                if (is_edge[x] != 0) look_at(image, static_cast<int>(left + x), y, mixes);
        }
    }
}

void Smoothing::run(Image& image, const PixelBox& box) {
    left_ = std::max(clamped(box.left, image.width), 1);
    top_ = std::max(clamped(box.top, image.height), 1);
    right_ = std::min(clamped(std::ceil(box.right), image.width), image.width - 1);
    bottom_ = std::min(clamped(std::ceil(box.bottom), image.height), image.height - 1);
    if (left_ >= right_ || top_ >= bottom_) return;
    find_brightness(image);
    const int middle = (top_ + bottom_) / 2;
    auto upper = std::async(std::launch::async, [&] { look_at_rows(image, top_, middle, mixes_[0]); });
    look_at_rows(image, middle, bottom_, mixes_[1]);
    upper.get();
    for (const Mixes& mixes : mixes_)
        for (const Mix& m : mixes) image.pixel[m.pixel] = m.color;
}

}  // namespace haptable
