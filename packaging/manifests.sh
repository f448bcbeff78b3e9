#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# manifests.sh OUT: the firmware as a library of each kind of project, without a scene: OUT/firmware/ for Arduino,
# PlatformIO, ESP-IDF, Zephyr, CMake and CMSIS-Pack; and OUT/library.json and OUT/zephyr/ for those of them that take a
# repository as a whole. Called by `make manifests` (OUT=.) from the project's root; what it writes is checked in, and a
# test compares. The list of files is what there is: firmware/*.c.
set -eu
export LC_ALL=C # one order of files everywhere
out=$1
name=haptable
version=$(sed -n 's/.*kVersion = "\([^"]*\)".*/\1/p' host/base/program.hpp)
what="The servo of soft objects that a haptic device can touch at 1 kHz"
url=https://example.org/haptable # the project has no address of its own yet
mkdir -p "$out/firmware/zephyr" "$out/zephyr"

# each BEGIN END: the sources, one a line.
each() { (cd firmware && for file in *.c; do echo "$1$file${2:-}"; done); }

# platformio FOLDER EXPORTED: library.json of a library with its sources in FOLDER.
platformio() {
    cat <<END
{
    "name": "$name",
    "version": "$version",
    "description": "$what, in C99: add model.c and model.h of a scene",
    "keywords": ["haptics", "haptic rendering", "soft body", "servo"],
    "authors": [{"name": "haptable"}],
    "license": "MIT",
    "frameworks": "*",
    "platforms": "*",
    "headers": "haptable.h",
    "build": {
        "srcDir": "$1",
        "srcFilter": ["+<*.c>"],
        "flags": ["-ffp-contract=off", "-fno-math-errno"]
    },
    "export": {
        "include": [$2]
    }
}
END
}
platformio . '"*.c", "*.h", "README.md", "library.json"' >"$out/firmware/library.json"
platformio firmware '"firmware/*.c", "firmware/*.h", "firmware/README.md", "LICENSE", "library.json"' >"$out/library.json"

# Sources beside the manifest: Arduino's flat layout, which leaves out folders like port/.
cat >"$out/firmware/library.properties" <<END
name=$name
version=$version
author=haptable
maintainer=haptable
sentence=$what.
paragraph=A finger position in, a force out, in bounded time. Add model.c and model.h of a scene to the sketch.
category=Device Control
url=$url
architectures=*
includes=haptable.h
END

cat >"$out/firmware/idf_component.yml" <<END
version: "$version"
description: $what
license: MIT
dependencies:
  idf: ">=5.0"
END

cat >"$out/firmware/CMakeLists.txt" <<END
# SPDX-License-Identifier: MIT
# Written by make manifests. A component of ESP-IDF; elsewhere add_subdirectory(firmware), then
# target_link_libraries(yours PRIVATE haptable::firmware), with model.c of a scene among your own sources.
cmake_minimum_required(VERSION 3.16)
set(haptable_sources
$(each '    ')
)
# The bits of the host.
set(haptable_options -ffp-contract=off -fno-math-errno)
if(ESP_PLATFORM)
    idf_component_register(SRCS \${haptable_sources} INCLUDE_DIRS .)
    target_compile_options(\${COMPONENT_LIB} PRIVATE \${haptable_options})
    return()
endif()
project(haptable_firmware VERSION $version LANGUAGES C)
add_library(haptable_firmware STATIC \${haptable_sources})
add_library(haptable::firmware ALIAS haptable_firmware)
target_include_directories(haptable_firmware PUBLIC .)
set_target_properties(haptable_firmware PROPERTIES C_STANDARD 99)
# The linker leaves out what the model does not name.
target_compile_options(haptable_firmware PRIVATE -ffreestanding \${haptable_options} -ffunction-sections -fdata-sections)
END

cat >"$out/firmware/zephyr/CMakeLists.txt" <<END
# SPDX-License-Identifier: MIT
# Written by make manifests. A module of Zephyr: CONFIG_HAPTABLE=y, and model.c of a scene in the application.
if(CONFIG_HAPTABLE)
  set(haptable_sources
$(each '    ')
  )
  list(TRANSFORM haptable_sources PREPEND \${CMAKE_CURRENT_LIST_DIR}/../)
  zephyr_library_named($name)
  zephyr_library_sources(\${haptable_sources})
  zephyr_library_compile_options(-ffp-contract=off -fno-math-errno)
  zephyr_include_directories(\${CMAKE_CURRENT_LIST_DIR}/..)
endif()
END

{
    printf '# SPDX-License-Identifier: MIT\nconfig HAPTABLE\n\tbool "%s"\n\tdepends on FPU\n' "$what"
    printf '\thelp\n\t  The firmware of haptable. The tables are in model.c and model.h of a scene, in the application.\n'
} >"$out/firmware/zephyr/Kconfig"

# module FOLDER: of a module whose root has these files in FOLDER.
module() { printf 'name: %s\nbuild:\n  cmake: %szephyr\n  kconfig: %szephyr/Kconfig\n' "$name" "$1" "$1"; }
module '' >"$out/firmware/zephyr/module.yml"
module firmware/ >"$out/zephyr/module.yml"

cat >"$out/firmware/haptable.haptable.pdsc" <<END
<?xml version="1.0" encoding="UTF-8"?>
<package schemaVersion="1.7.28" xmlns:xs="http://www.w3.org/2001/XMLSchema-instance" xs:noNamespaceSchemaLocation="PACK.xsd">
  <vendor>haptable</vendor>
  <name>haptable</name>
  <description>$what</description>
  <url></url>
  <license>README.md</license>
  <releases>
    <release version="$version">See CHANGELOG.md of haptable</release>
  </releases>
  <taxonomy>
    <description Cclass="Haptics">Objects that a haptic device can touch</description>
  </taxonomy>
  <components>
    <component Cclass="Haptics" Cgroup="Servo" Cversion="$version">
      <description>The servo in C99, for model.c of a scene: compile with -ffp-contract=off</description>
      <files>
        <file category="header" name="haptable.h"/>
$(each '        <file category="sourceC" name="' '"/>')
        <file category="doc" name="README.md"/>
      </files>
    </component>
  </components>
</package>
END
