// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/tell.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/base/finger_advice.hpp"
#include "host/body/locking.hpp"
#include "host/mesh/audit.hpp"
#include "host/precompute/digits.hpp"
#include "host/precompute/facts.hpp"
#include "host/precompute/press.hpp"

namespace haptable {

void say(const Telling& telling, const char* kind, const std::vector<std::string>& lines) {
    for (const std::string& line : lines)
        if (!telling.quiet) fmt::print(stderr, "{}: {}: {}\n", telling.program, kind, line);
}

void tell(const Telling& telling, const Scene& scene, const std::filesystem::path& folder, const Result& result) {
    const auto& [body, summary, unchanged] = result;
    say(telling, "note", body.mesh.notes);
    say(telling, "warning", warnings_of(summary.audit, scene.mesh.scale_m));
    say(telling, "warning", holding_warnings(scene, body));
    say(telling, "warning", unchanged ? kept_warnings(folder) : run_warnings(scene, summary));
    if (telling.json)
        fmt::print("{}", unchanged ? read_file(folder / "summary.json")
                                   : summary_text(facts_of(scene, body, summary), scene, body, summary));
    else if (unchanged && !telling.quiet)
        fmt::print("{} (model {:016x}) is unchanged in {}: nothing to compute; --force computes it again\n", scene.name,
                   summary.identity.model_hash, folder.string());
    else if (!telling.quiet) {
        const PressStiffness press = press_stiffness(scene, folder);
        fmt::print("{}\n{}  written to {}\n", to_table(scene, body, summary, press), describe(press, scene),
                   folder.string());
        if (scene.contact.force == ForceLaw::kInterpolated && scene.contact.god_object == GodObject::kNearest)
            fmt::print("{}", finger_advice(pad_radius_m(scene, body.mesh)));
    }
}

}  // namespace haptable
