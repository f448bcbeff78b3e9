// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/modules.hpp"

#include <gtest/gtest.h>

#include "host/base/error.hpp"

namespace haptable {

namespace {

TEST(MeshModules, AreFoundBesideTheProgramsFolder) {
    EXPECT_NE(find_in_module("a.msh", "haptable-gmsh", "haptable_gmsh_read"), nullptr);
    EXPECT_NE(find_in_module("a.stl", "haptable-cgal", "haptable_cgal_read"), nullptr);
    for (const char* function : {"haptable_cgal_fill", "haptable_cgal_wrap", "haptable_cgal_distances"})
        EXPECT_NE(find_in_module("a.stl", "haptable-cgal", function), nullptr) << function;
}

TEST(MeshModules, OneThatIsMissingIsNamedWithWhatToDo) {
    try {
        find_in_module("a.msh", "haptable-none", "haptable_none");
        FAIL();
    } catch (const Error& error) {
        const std::string what = error.what();
        EXPECT_TRUE(what.starts_with("a.msh: reading it needs haptable-none.so, which is not in ")) << what;
        EXPECT_TRUE(what.ends_with(": run make")) << what;
    }
}

}  // namespace

}  // namespace haptable
