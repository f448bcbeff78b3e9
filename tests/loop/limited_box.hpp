// SPDX-License-Identifier: GPL-2.0-or-later
// The soft box with every limit of a scene's [device].
#pragma once

#include "codegen/laws.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {

class LimitedBox {
public:
    LimitedBox() {
        Tables tables = box_.model().tables();
        tables.limits = {5.0, 200.0, 0.3, 5.0, 0.05, true, true};
        set_laws(tables, model_);
        model_.crc = haptable_crc_of(&model_, haptable_span_of_model);
    }
    ServoScene scene() const { return {&model_, box_.scene().node, "box"}; }
    haptable_model& model() { return model_; }

private:
    SoftBox box_;
    haptable_model model_ = *box_.scene().model;
};

}  // namespace haptable::test
