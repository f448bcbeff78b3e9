// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/modules.hpp"

#include <gtest/gtest.h>

#include "tests/error_of.hpp"

namespace haptable {
namespace {

TEST(MeshModules, AreFoundBesideTheProgramsFolder) {
    EXPECT_NE(find_in_module("a.msh", "haptable-gmsh", "haptable_gmsh_read"), nullptr);
    EXPECT_NE(find_in_module("a.stl", "haptable-cgal", "haptable_cgal_read"), nullptr);
    for (const char* function : {"haptable_cgal_fill", "haptable_cgal_wrap", "haptable_cgal_distances"})
        EXPECT_NE(find_in_module("a.stl", "haptable-cgal", function), nullptr) << function;
}

TEST(MeshModules, OneThatIsMissingIsNamedWithWhatToDo) {
    const std::string said = test::error_of([&] { find_in_module("a.msh", "haptable-none", "haptable_none"); });
    EXPECT_TRUE(said.starts_with("a.msh: reading it needs haptable-none.so, which is not in ")) << said;
    EXPECT_TRUE(said.ends_with(": run make")) << said;
}

}  // namespace
}  // namespace haptable
