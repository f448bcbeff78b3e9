// SPDX-License-Identifier: GPL-2.0-or-later
// NumPy's .npy format 1.0, C order, little-endian:
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

namespace haptable {

/// IEEE 754 binary16 as it is stored.
struct Half {
    std::uint16_t bits = 0;
};
/// Rounds to the nearest, ties to even; beyond 65504 infinity.
Half to_half(float value);
float to_float(Half value);

/// An array as a .npy file holds it: `values` in C order, the product of `shape` many.
template <typename T>
struct Array {
    std::vector<std::size_t> shape;
    std::vector<T> values;

    bool operator==(const Array&) const = default;
};

/// Writes a .npy file piece by piece, so that it need not fit in memory. T: integers below, float, double.
template <typename T>
class NpyWriter {
public:
    NpyWriter(const std::filesystem::path& path, const std::vector<std::size_t>& shape);
    /// Appends values in C order. Throws Error when they cannot be written or are more than the shape holds.
    void append(std::span<const T> values);
    /// Throws Error unless exactly the shape's many values were appended and are on their way to the disk.
    void close();

private:
    std::filesystem::path path_;
    std::ofstream out_;
    std::size_t left_;
};

/// A .npy file that is written in any order: made at its full size, mapped into memory, values 0 at first. The room on
/// the disk is taken at once, so that a full disk is an error here and not a signal later.
template <typename T>
class WritableNpy {
public:
    /// T: float, double, Half. `keep`: a file of the same type and shape keeps its values.
    WritableNpy(const std::filesystem::path& path, const std::vector<std::size_t>& shape, bool keep = false);
    ~WritableNpy();
    WritableNpy(const WritableNpy&) = delete;
    WritableNpy& operator=(const WritableNpy&) = delete;

    std::span<T> values() const { return values_; }

private:
    std::span<T> values_;
    void* map_ = nullptr;
    std::size_t map_bytes_ = 0;
};

/// Writes a whole array. T: int32_t, int16_t, int8_t, uint8_t, float, double. Throws Error that names the path.
template <typename T>
void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape, std::span<const T> values);

/// Reads a whole array whose element type must be T. Throws Error that names the path and what is wrong with it.
template <typename T>
Array<T> read_npy(const std::filesystem::path& path);

/// The array of a file, mapped into memory and read where it is needed. T: int32_t, float, double, Half.
template <typename T>
class MappedNpy {
public:
    explicit MappedNpy(const std::filesystem::path& path);
    ~MappedNpy();
    MappedNpy(const MappedNpy&) = delete;
    MappedNpy& operator=(const MappedNpy&) = delete;

    const std::vector<std::size_t>& shape() const { return shape_; }
    std::span<const T> values() const { return values_; }

private:
    std::vector<std::size_t> shape_;
    std::span<const T> values_;
    void* map_ = nullptr;
    std::size_t map_bytes_ = 0;
};

}  // namespace haptable
