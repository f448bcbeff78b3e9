// SPDX-License-Identifier: GPL-2.0-or-later
// The tests of an Inverse against DistributedInverse, under mpirun: rank 0 runs and reports them, the others serve.
#include <gtest/gtest.h>
#include <mpi.h>

#include "host/inverse/mpi/distributed_inverse.hpp"
#include "tests/host/inverse/inverses.hpp"

namespace haptable::test {
namespace {

/// One for all tests: every rank has to make it.
std::shared_ptr<Inverse> distributed;

}  // namespace

std::vector<InverseCase> inverses() {
    return {{"Distributed", [] { return distributed; }}};
}

int work(int argc, char** argv) {
    const auto inverse = std::make_shared<DistributedInverse>(MPI_COMM_WORLD);
    if (!inverse->leads()) {
        inverse->serve();
        return 0;
    }
    distributed = inverse;
    testing::InitGoogleTest(&argc, argv);
    const int status = RUN_ALL_TESTS();
    distributed.reset();
    return status;
}

}  // namespace haptable::test

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    const int status = haptable::test::work(argc, argv);
    MPI_Finalize();
    return status;
}
