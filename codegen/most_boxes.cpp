// SPDX-License-Identifier: GPL-2.0-or-later
// max over m of the boxes that meet a ball around m: branch and bound over the places m of a segment's middle.
//
// A segment of length w lies in the ball of radius w/2 around its middle. A cell of middles is bounded by the boxes
// that come within w/2 of the cell; the cell with the largest bound is halved until it is small against the ball, and
// then its bound holds for all, as every other cell's is lower.
#include <algorithm>
#include <queue>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

namespace {

constexpr double kRounding = 1.0;     // grid steps: the servo's own, in the segment's ends
constexpr double kSmallCell = 0.125;  // of the ball's radius
constexpr int kMostCells = 20'000;    // then the largest bound so far is given: still one

using Numbers = std::vector<std::uint32_t>;

/// A cube of middles, and the inner boxes that a segment around them may meet.
struct Cell {
    std::array<double, 3> low;
    double side;
    Numbers boxes;

    bool operator<(const Cell& other) const { return boxes.size() < other.boxes.size(); }
};

class MostBoxes {
public:
    MostBoxes(const std::vector<haptable_box>& boxes, double radius) : boxes_(boxes), radius_(radius + kRounding) {}

    /// The most inner boxes that a segment meets.
    std::size_t find() {
        queue_.push(whole());
        for (int cells = 0; cells < kMostCells && queue_.top().side > kSmallCell * radius_; ++cells) halve();
        return queue_.top().boxes.size();
    }

private:
    Cell whole() const {
        Cell cell{{}, 0.0, {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cell.low[axis] = boxes_[0].low[axis] - radius_;
            cell.side = std::max(cell.side, boxes_[0].high[axis] + radius_ - cell.low[axis]);
        }
        for (std::uint32_t i = 0; i < boxes_.size(); ++i)
            if (boxes_[i].patch == HAPTABLE_NONE) cell.boxes.push_back(i);
        return cell;
    }

    void halve() {
        const Cell cell = queue_.top();
        queue_.pop();
        for (unsigned octant = 0; octant < 8; ++octant) {
            Cell part{cell.low, 0.5 * cell.side, {}};
            for (std::size_t axis = 0; axis < 3; ++axis)
                if ((octant >> axis & 1U) != 0) part.low[axis] += part.side;
            std::copy_if(cell.boxes.begin(), cell.boxes.end(), std::back_inserter(part.boxes),
                         [&](std::uint32_t box) { return comes_near(part, boxes_[box]); });
            queue_.push(std::move(part));
        }
    }

    bool comes_near(const Cell& cell, const haptable_box& box) const {
        double gap2 = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double gap =
                std::max({0.0, box.low[axis] - (cell.low[axis] + cell.side), cell.low[axis] - box.high[axis]});
            gap2 += gap * gap;
        }
        return gap2 <= radius_ * radius_;
    }

    const std::vector<haptable_box>& boxes_;
    double radius_;
    std::priority_queue<Cell> queue_;
};

}  // namespace

std::size_t most_boxes(const ServoModel& model, double segment_m) {
    // The first box, and two more for each inner one that is met.
    return 1 + 2 * MostBoxes(model.box, 0.5 * segment_m * static_cast<double>(model.grid_per_m)).find();
}

void measure_search(ServoModel& model) {
    model.search = {model.box.size(), most_boxes(model, static_cast<double>(HAPTABLE_FAST_SEGMENT_M)),
                    HAPTABLE_TICK_BOXES};
}

}  // namespace haptable
