// SPDX-License-Identifier: GPL-2.0-or-later
// The Debian packages: no error of lintian's, whole among themselves, and for every processor of the kind. `make
// deb-tried` installs them into an empty Debian, which takes minutes.
#include <gtest/gtest.h>

#include "tests/process.hpp"

namespace haptable::test {
namespace {

TEST(DebianPackages, HaveNoErrorAndNothingTwice) {
    const Outcome made = run("make -s deb BUILD=" + build_folder().string());
    ASSERT_EQ(made.status, 0) << made.out << made.err;
    EXPECT_EQ(made.out.find("E: "), std::string::npos) << made.out;
    const std::string debs = (build_folder() / "package/deb").string();
    const Outcome files =
        run("for deb in " + debs + "/*.deb; do dpkg-deb --contents $deb; done | grep -v '/$' | awk '{ print $6 }'");
    for (const char* file :
         {"./usr/bin/haptable-build", "./usr/lib/haptable/haptable-gmsh.so", "./usr/share/haptable/firmware/haptable.h",
          "./usr/share/haptable/firmware/zephyr/module.yml", "./usr/include/haptable/haptable_library.h",
          "libhaptable.so.1", "libhaptable.so"})
        EXPECT_NE((files.out + "\n").find(std::string(file) + "\n"), std::string::npos) << file;
    EXPECT_EQ(run("printf '%s' '" + files.out + "' | sort | uniq -d").out, "");
    const Outcome needs = run("dpkg-deb --field " + debs + "/haptable_*.deb Depends");
    for (const char* library : {"liblcm1", "libgmsh4", "libcholmod3", "libopenblas0", "g++"})
        EXPECT_NE(needs.out.find(library), std::string::npos) << needs.out;
    // Equation 8 is compiled for this machine elsewhere: no register of AVX here.
    EXPECT_EQ(run("objdump -d " + debs + "/deformation.o | grep -cE '%[yz]mm'").out, "0\n");
}

}  // namespace
}  // namespace haptable::test
