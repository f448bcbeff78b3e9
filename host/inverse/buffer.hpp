// SPDX-License-Identifier: GPL-2.0-or-later
// Large work memory: one mapping for a whole run. Taking and giving back every front would cost a tenth of a long run
// in the kernel, and leaves holes in the heap. (Huge pages cost more than they bring: the kernel compacts memory for
// them.)
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <utility>

namespace haptable {

/// [count] numbers of T. Only what is written to takes memory.
template <typename T>
class Buffer {
public:
    explicit Buffer(std::size_t count = 0) : bytes_(count * sizeof(T)) {
        if (count == 0) return;
        void* memory =
            mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (memory == MAP_FAILED) throw std::bad_alloc();
        memory_ = static_cast<T*>(memory);
    }
    ~Buffer() {
        if (memory_ != nullptr) munmap(memory_, bytes_);
    }
    Buffer(Buffer&& other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        std::swap(memory_, other.memory_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    T* data() const { return memory_; }
    std::size_t size() const { return bytes_ / sizeof(T); }

private:
    T* memory_ = nullptr;
    std::size_t bytes_ = 0;
};

/// Two stacks that grow towards one another in one buffer.
template <typename T>
class TwoStacks {
public:
    explicit TwoStacks(std::size_t capacity = 0) : buffer_(capacity), top_(capacity) {}
    /// `end` 0: the lower one, 1: the upper one. The caller knows the capacity from a walk without numbers.
    T* push(int end, std::size_t count) {
        if (bottom_ + count > top_) throw std::bad_alloc();
        if (end == 0) return buffer_.data() + std::exchange(bottom_, bottom_ + count);
        return buffer_.data() + (top_ -= count);
    }
    void pop(int end, std::size_t count) {
        if (end == 0)
            bottom_ -= count;
        else
            top_ += count;
    }

private:
    Buffer<T> buffer_;
    std::size_t bottom_ = 0, top_;
};

}  // namespace haptable
