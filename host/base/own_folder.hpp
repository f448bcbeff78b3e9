// SPDX-License-Identifier: GPL-2.0-or-later
// A folder that a program writes is haptable's own, by a mark in it, or new: nothing else is written over or removed.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace haptable {

/// What the mark of a folder says that it holds.
inline constexpr const char *kTables = "tables", *kSession = "session", *kPictures = "pictures", *kStrokes = "strokes";

/// The right to write a folder, from construction to destruction. FOLDER/.haptable is its mark and its lock (flock):
/// the first line says what the folder holds, the others are the names of all that haptable made there. The kernel
/// takes the lock back however the process ends, and the mark tells the next one what was left.
class OwnFolder {
public:
    /// Makes the folder where there is none. holds: what will be written, "tables". known: where there is no mark,
    /// names of files that are surely haptable's; one that is there makes the folder haptable's. Throws Error that
    /// names the folder and says what to do where it holds files without a mark, or something else; where the mark is a
    /// link or another user's; and the process where another one is writing it.
    OwnFolder(std::filesystem::path folder, const std::string& holds, const std::vector<std::string>& known = {});
    /// A folder in which nothing is left goes where haptable made it; else the mark goes.
    ~OwnFolder();
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;

    const std::filesystem::path& path() const { return folder_; }
    /// Where to write a file or folder of that name, which the mark has from now on. Throws Error where it is there and
    /// is not haptable's.
    std::filesystem::path file(const std::string& name);
    /// Removes it, with what is in it, where it is haptable's.
    void remove(const std::string& name);
    /// Removes all that is haptable's but for those names.
    void clear(const std::set<std::string>& kept = {});

private:
    bool open_once(const std::vector<std::string>& known);
    void read(const std::string& holds, const std::vector<std::string>& known);
    void append(const std::string& line) const;
    bool has_only_mark() const;
    void require_no_others(const std::vector<std::string>& known) const;
    [[noreturn]] void fail(const std::string& why) const;

    std::filesystem::path folder_, mark_;
    int descriptor_ = -1;
    bool made_ = false;           ///< by haptable: the mark has "."
    std::set<std::string> ours_;  ///< names in the folder
};

}  // namespace haptable
