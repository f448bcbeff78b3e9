// SPDX-License-Identifier: GPL-2.0-or-later
// One writer a folder.
#pragma once

#include <filesystem>

namespace haptable {

/// The right to write a folder and what stands beside it, from construction to destruction: a lock (flock) on the file
/// FOLDER.lock, which says who holds it. The kernel takes the lock back however the process ends; a file that a killed
/// one left is taken over.
class FolderLock {
public:
    /// folder: need not exist; its parent is made. Throws Error that names the process that holds the lock.
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    std::filesystem::path file_;
    int descriptor_ = -1;
};

/// Removes what processes that are gone left half done beside the folder: FOLDER.partial-PID. Needs the folder's lock.
void remove_leftovers(const std::filesystem::path& folder);

}  // namespace haptable
