// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/template.hpp"

#include <gtest/gtest.h>

#include "tests/error_of.hpp"

namespace haptable::test {
namespace {

const TemplateValues kValues{
    {"name", "cube"}, {"none", ""}, {"rows", "    1,\n    2,\n"}, {"row", "    3,"}, {"mail", "a@b"}};

TEST(Template, PlacesAreFilled) {
    EXPECT_EQ(filled("int @name@_@name@;\n", kValues), "int cube_cube;\n");
    EXPECT_EQ(filled("@name@", kValues), "cube");
    EXPECT_EQ(filled("by me@example.org, and @name@ by @mail@", kValues), "by me@example.org, and cube by a@b");
}

TEST(Template, ALineThatIsAPlaceIsItsValuesLines) {
    EXPECT_EQ(filled("a[] = {\n@rows@\n@row@\n@none@\n};\n", kValues), "a[] = {\n    1,\n    2,\n    3,\n};\n");
}

TEST(Template, OnlyTheBranchOfAValueStays) {
    EXPECT_EQ(filled("a\n@if name\nb\n@else\nc\n@end\nd\n", kValues), "a\nb\nd\n");
    EXPECT_EQ(filled("a\n@if none\nb\n@else\nc\n@end\nd\n", kValues), "a\nc\nd\n");
    EXPECT_EQ(filled("@if name\n@if none\nb\n@else\nc\n@end\nd\n@end\n", kValues), "c\nd\n");
    EXPECT_EQ(filled("@if none\n@if unknown\n@unknown@\n@else\nc\n@end\n@end\nd\n", kValues), "d\n");
}

TEST(Template, ANameWithoutAValueIsAnError) {
    EXPECT_EQ(error_of([] { filled("@nobody@", kValues); }), "a template asks for @nobody@, which has no value");
    EXPECT_NE(error_of([] { filled("@if nobody\n@end\n", kValues); }), "no error");
}

}  // namespace
}  // namespace haptable::test
