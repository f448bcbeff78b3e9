// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-precompute-mpi: haptable-precompute on several machines, under mpirun.
#include <fmt/format.h>
#include <mpi.h>

#include <exception>

#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/inverse/mpi/distributed_inverse.hpp"
#include "host/precompute/owner.hpp"
#include "host/precompute/tell.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    fs::path scene;
    fs::path folder;
    PrecomputeOptions how;
    Telling telling{"haptable-precompute-mpi"};
};

void run(const Options& options, DistributedInverse& inverse) {
    const Scene scene = read_scene(options.scene);
    const fs::path folder = options.folder.empty() ? fs::path("build") / scene.name : options.folder;
    Progress progress(options.telling.quiet);
    PrecomputeOptions how = options.how;
    how.inverse = &inverse;
    if (options.folder.empty()) require_own(folder, scene);
    const Result result = precompute(scene, folder, progress, how);
    if (options.folder.empty()) note_owner(folder, scene);
    tell(options.telling, scene, folder, result);
}

/// Only rank 0 reads the command line and the scene, and speaks.
int lead(int argc, char** argv, DistributedInverse& inverse) {
    CommandLine app(
        "haptable-precompute on several machines: mpirun -n RANKS haptable-precompute-mpi SCENE -o DIR. The factor is "
        "distributed over the ranks; only the first one reads SCENE and writes DIR.",
        "haptable-precompute-mpi");
    Options options;
    app.option("SCENE", options.scene, "the scene file (TOML)").required();
    app.option("-o", options.folder, "where to write; default build/<name of the scene>");
    app.option("--tolerance", options.how.tolerance, "as of haptable-precompute: met by any value, all is in double")
        .range(0.0, 1e-2);
    app.option("--column-tolerance", options.how.column_tolerance, "the same").range(0.0, 1e-2);
    app.flag("--force", options.how.force, "compute even where DIR holds the same tables already");
    app.flag("--json", options.telling.json, "the summary as JSON on standard output instead of the table");
    app.flag("--quiet", options.telling.quiet, "no table, no notes, no progress bar");
    return run_program(app, argc, argv, [&] { run(options, inverse); });
}

/// What one rank alone throws would leave the others waiting for ever.
int work(int argc, char** argv) try {
    DistributedInverse inverse(MPI_COMM_WORLD);
    if (inverse.leads()) return lead(argc, argv, inverse);
    inverse.serve();
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "haptable-precompute-mpi: {}\n", error.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    catch_interrupts();
    const int status = work(argc, argv);
    MPI_Finalize();
    return status;
}
