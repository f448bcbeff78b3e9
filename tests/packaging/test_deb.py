# SPDX-License-Identifier: GPL-2.0-or-later
"""The Debian packages: no error of lintian's, whole among themselves, and for every processor of the kind. `make
deb-tried` installs them into an empty Debian, which takes minutes."""

from programs import BUILT, done, make, run


def test_have_no_error_and_nothing_twice():
    made = make("deb")
    assert made.status == 0, made.out + made.err
    assert "E: " not in made.out
    debs = BUILT / "package/deb"
    files = [line.split()[5] for deb in debs.glob("*.deb") for line in done(["dpkg-deb", "--contents", deb]).splitlines()
             if not line.endswith("/")]
    for name in ("./usr/bin/haptable-build", "./usr/lib/haptable/haptable-gmsh.so",
                 "./usr/share/haptable/firmware/haptable.h", "./usr/share/haptable/firmware/zephyr/module.yml",
                 "./usr/include/haptable/haptable_library.h"):
        assert name in files
    # The last word of a link's line is what it points to.
    assert {"libhaptable.so.1", "libhaptable.so"} <= {file.rsplit("/", 1)[1] for file in files}
    assert len(files) == len(set(files))
    needs = done(f"dpkg-deb --field {debs}/haptable_*.deb Depends")
    for library in ("liblcm1", "libgmsh4", "libcholmod3", "libopenblas0", "g++"):
        assert library in needs
    # Equation 8 is compiled for this machine elsewhere: no register of AVX here.
    assert run(f"objdump -d {debs}/deformation.o | grep -cE '%[yz]mm'").out == "0\n"
