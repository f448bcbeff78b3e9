// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies that tests stroke: their tables are made once for each way of touching them.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "host/strokes/campaign.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

class StrokedTables {
public:
    explicit StrokedTables(Scene scene) : scene_(std::move(scene)), tables_(scene_, folder_.path()) {}

    const Scene& scene() const { return scene_; }
    const StrokedBody& body(const TouchMode& mode) {
        auto& body = body_[mode.body.name() + (mode.is_coupled() ? " two " : " ") + word(mode.force)];
        if (!body) body = std::make_unique<StrokedBody>(tables_.with(mode));
        return *body;
    }

private:
    TemporaryFolder folder_;
    Scene scene_;
    BodyTables tables_;
    std::map<std::string, std::unique_ptr<StrokedBody>> body_;
};

inline constexpr BodyKind kFree{1, false}, kRings{0, true};
inline constexpr auto kNearest = GodObject::kNearest, kLeast = GodObject::kLeastEnergy;
inline const std::vector<std::filesystem::path> kOurMeshes{"meshes", "meshes/hard"};

/// Of the body with that in its name.
inline StrokedTables& tables_of(const std::string& mesh,
                                const std::vector<std::filesystem::path>& places = kOurMeshes) {
    static const TemporaryFolder filled;
    static std::map<std::string, std::unique_ptr<StrokedTables>> all;
    auto& tables = all[places.front().string() + " " + mesh];
    if (!tables) {
        const StrokedMeshes meshes = collect_meshes(places, {mesh}, 50'000, filled.path());
        EXPECT_EQ(meshes.taken.size(), 1U) << (meshes.left_out.empty() ? mesh : meshes.left_out[0].why);
        tables = std::make_unique<StrokedTables>(meshes.taken.at(0).scene);
    }
    return *tables;
}

/// A body in one mode.
struct Stroked {
    Stroked(StrokedTables& tables, const TouchMode& mode, StepOfScene* step = &step_scene)
        : scene(in_mode(tables.scene(), mode)),
          body(tables.body(mode)),
          model(body, scene.contact, mode.tool ? random_tools(body, scene) : std::vector<ToolTables>{}),
          touched(model.touched()) {
        touched.step = step;
    }

    Stroke stroke(std::uint64_t seed, std::uint64_t number) const {
        return make_stroke(touched.of_stroke(number), seed, number);
    }
    Verdict judged(std::uint64_t seed, std::uint64_t number) const {
        return judge(touched.of_stroke(number), stroke(seed, number));
    }
    Tally tally(std::uint64_t seed, std::size_t strokes) const {
        Workers workers(1);
        return run_strokes(touched, seed, strokes, workers, [](std::size_t) {});
    }

    Scene scene;
    const StrokedBody& body;
    StrokedModel model;
    Touched touched;
};

}  // namespace haptable::test
