// SPDX-License-Identifier: GPL-2.0-or-later
// Files are read whole, and written beside and then renamed: a reader never sees half a file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace haptable {

/// The whole file. Throws Error that names the path when it cannot be read.
std::string read_file(const std::filesystem::path& path);

/// The whole file, without the mark of UTF-8 that some editors put first. Throws Error for UTF-16 too, by its mark.
std::string read_text(const std::filesystem::path& path);

/// Writes `bytes` to `path`, whole or not at all. Throws Error that names the path.
void write_file(const std::filesystem::path& path, std::string_view bytes);

enum class StagedKind { file, folder };

/// A file or folder under construction, beside its final place: NAME.haptable-PROCESS, which it holds locked. Unless
/// commit() is called it is removed; where the process was killed, the next one that writes into its folder removes it.
class StagedPath {
public:
    /// Makes it, empty. A link's target is what will be replaced. Throws Error for a device or a pipe, and where it
    /// cannot be made.
    explicit StagedPath(std::filesystem::path final_path, StagedKind kind = StagedKind::file);
    ~StagedPath();
    StagedPath(const StagedPath&) = delete;
    StagedPath& operator=(const StagedPath&) = delete;

    /// Where to write meanwhile: in the folder of the final path, so that renaming it is atomic.
    const std::filesystem::path& path() const { return temporary_; }
    /// Renames it to the final path, over a file of that name.
    void commit();

private:
    void make(StagedKind kind);
    void close();

    std::filesystem::path final_;
    std::filesystem::path temporary_;
    int descriptor_ = -1;
};

/// Whether the path, itself no link, names the open file.
bool names_open(const std::filesystem::path& path, int descriptor);

/// Removes what killed processes left under construction in a folder: every NAME.haptable-PROCESS there that is this
/// user's and that nobody holds locked.
void remove_leftovers(const std::filesystem::path& folder);

}  // namespace haptable
