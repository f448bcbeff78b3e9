// SPDX-License-Identifier: GPL-2.0-or-later
// A scene's file that a test writes and reads.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "host/base/file.hpp"
#include "host/scene/scene.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

class SceneFile : public testing::Test {
protected:
    Scene read(const std::string& text) const {
        write_file(path_, text);
        return read_scene(path_);
    }

    const TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_.path() / "scene.toml";
};

/// A scene's text with another part.
inline std::string replaced(std::string text, const std::string& part, const std::string& by) {
    return text.replace(text.find(part), part.size(), by);
}

}  // namespace haptable::test
