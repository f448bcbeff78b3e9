// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/npy.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <string>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

Half to_half(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const auto sign = static_cast<std::uint16_t>((bits >> 16U) & 0x8000U);
    const float size = std::bit_cast<float>(bits & 0x7FFFFFFFU);
    if (!(size < 0x1p16F)) return {static_cast<std::uint16_t>(sign | (size != size ? 0x7E00U : 0x7C00U))};
    if (size < 0x1p-14F)  // subnormal: adding 0.5 leaves steps of 2^-24, rounded by the processor
        return {static_cast<std::uint16_t>(sign | (std::bit_cast<std::uint32_t>(size + 0.5F) & 0x0FFFU))};
    const std::uint32_t odd = (bits >> 13U) & 1U;
    const std::uint32_t rounded = (bits & 0x7FFFFFFFU) + 0x0FFFU + odd - ((127U - 15U) << 23U);
    return {static_cast<std::uint16_t>(sign | (rounded >> 13U))};
}

float to_float(Half value) {
    const std::uint32_t sign = (value.bits & 0x8000U) << 16U, rest = value.bits & 0x7FFFU;
    if (rest >= 0x7C00U) return std::bit_cast<float>(sign | 0x7F800000U | ((rest & 0x3FFU) << 13U));
    const float size = rest < 0x0400U ? 0x1p-24F * static_cast<float>(rest)
                                      : std::bit_cast<float>((rest << 13U) + ((127U - 15U) << 23U));
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(size));
}

static_assert(std::endian::native == std::endian::little, "the .npy files are little-endian: swap bytes on this host");

namespace {

constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};
constexpr std::size_t kPreamble = 10;  // magic, version and the header's length (uint16)
constexpr std::size_t kAlign = 64;
constexpr std::size_t kMostValues = std::size_t{1} << 48;  // more is a damaged header, whose bytes would overflow

template <typename T>
constexpr const char* kType = nullptr;
template <>
constexpr const char* kType<std::int32_t> = "<i4";
template <>
constexpr const char* kType<std::int16_t> = "<i2";
template <>
constexpr const char* kType<std::int8_t> = "|i1";
template <>
constexpr const char* kType<std::uint8_t> = "|u1";
template <>
constexpr const char* kType<Half> = "<f2";
template <>
constexpr const char* kType<float> = "<f4";
template <>
constexpr const char* kType<double> = "<f8";

std::size_t product(const std::vector<std::size_t>& shape) {
    std::size_t n = 1;
    for (std::size_t extent : shape) n *= extent;
    return n;
}

template <typename T>
std::string header(const std::vector<std::size_t>& shape) {
    std::string extents;  // as NumPy writes a tuple: "(73,)", "(73, 3)"
    for (std::size_t extent : shape) extents += std::to_string(extent) + (shape.size() == 1 ? "," : ", ");
    if (shape.size() > 1) extents.resize(extents.size() - 2);
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", kType<T>, extents);
    const std::size_t bytes = (kPreamble + text.size() + 1 + kAlign - 1) / kAlign * kAlign;
    text.resize(bytes - kPreamble - 1, ' ');
    text += '\n';
    const auto length = static_cast<std::uint16_t>(text.size());
    std::string out(kMagic);
    out += static_cast<char>(length & 0xFFU);
    out += static_cast<char>(length >> 8U);
    return out + text;
}

struct Header {
    std::vector<std::size_t> shape;
    std::size_t bytes = 0;  // where the values begin
};

/// Takes `piece` off the front of `text`; false where it does not stand there.
bool skip(std::string_view& text, std::string_view piece) {
    if (!text.starts_with(piece)) return false;
    text.remove_prefix(piece.size());
    return true;
}

/// Reads "3, 4), }" into extents; false where it is damaged or its product is more than any file holds.
bool read_extents(std::string_view& text, std::vector<std::size_t>& extents) {
    std::size_t count = 1;
    while (!skip(text, "), }")) {
        std::size_t extent = 0;
        const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), extent);
        if (failed != std::errc() || (extent != 0 && count > kMostValues / extent)) return false;
        count *= extent;
        extents.push_back(extent);
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        if (!skip(text, ", ")) skip(text, ",");  // "(73,)" and "(73, 3)"
    }
    return true;
}

/// Reads the header of `text`, the beginning of a file of `file_bytes` bytes, and checks it against T.
template <typename T>
Header parse(const std::filesystem::path& path, std::string_view text, std::size_t file_bytes) {
    if (text.size() < kPreamble || text.substr(0, kMagic.size()) != kMagic)
        throw Error(path.string() +
                    ": is not a .npy file of format 1.0: make the tables again with haptable-precompute");
    const std::size_t length = static_cast<unsigned char>(text[8]) + 256U * static_cast<unsigned char>(text[9]);
    if (text.size() < kPreamble + length)
        throw Error(path.string() + ": ends within its header: make the tables again");
    std::string_view dictionary = text.substr(kPreamble, length);
    if (!skip(dictionary, fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': (", kType<T>)))
        throw Error(
            fmt::format("{}: holds another type than {} in C order: make the tables again", path.string(), kType<T>));
    Header head;
    if (!read_extents(dictionary, head.shape) || dictionary.find_first_not_of(" \n") != std::string_view::npos)
        throw Error(path.string() + ": has a damaged shape in its header: make the tables again");
    head.bytes = kPreamble + length;
    if (file_bytes != head.bytes + product(head.shape) * sizeof(T))
        throw Error(fmt::format("{}: has {} bytes where its shape needs {}: make the tables again", path.string(),
                                file_bytes, head.bytes + product(head.shape) * sizeof(T)));
    return head;
}

}  // namespace

template <typename T>
NpyWriter<T>::NpyWriter(const std::filesystem::path& path, const std::vector<std::size_t>& shape)
    : path_(path), out_(path, std::ios::binary), left_(product(shape)) {
    const std::string head = header<T>(shape);
    out_.write(head.data(), static_cast<std::streamsize>(head.size()));
    if (!out_) throw Error(path.string() + ": cannot be written: is there room, and may you write there?");
}

template <typename T>
void NpyWriter<T>::append(std::span<const T> values) {
    if (values.size() > left_) throw Error(path_.string() + ": more values than its shape holds");
    left_ -= values.size();
    out_.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
    if (!out_) throw Error(path_.string() + ": cannot be written: is the disk full?");
}

template <typename T>
void NpyWriter<T>::close() {
    out_.close();
    if (!out_) throw Error(path_.string() + ": cannot be written: is the disk full?");
    if (left_ != 0) throw Error(fmt::format("{}: {} values are missing", path_.string(), left_));
}

template <typename T>
void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape, std::span<const T> values) {
    StagedPath beside(path);
    NpyWriter<T> writer(beside.path(), shape);
    writer.append(values);
    writer.close();
    beside.commit();
}

template <typename T>
Array<T> read_npy(const std::filesystem::path& path) {
    const std::string text = read_file(path);
    const Header head = parse<T>(path, text, text.size());
    Array<T> array{head.shape, std::vector<T>(product(head.shape))};
    std::memcpy(array.values.data(), text.data() + head.bytes, text.size() - head.bytes);
    return array;
}

template <typename T>
MappedNpy<T>::MappedNpy(const std::filesystem::path& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (file < 0 || fstat(file, &status) != 0) {
        if (file >= 0) close(file);
        throw Error(path.string() + ": cannot be read: make the tables with haptable-precompute");
    }
    map_bytes_ = static_cast<std::size_t>(status.st_size);
    map_ = map_bytes_ == 0 ? MAP_FAILED : mmap(nullptr, map_bytes_, PROT_READ, MAP_SHARED, file, 0);
    close(file);
    if (map_ == MAP_FAILED) throw Error(path.string() + ": cannot be mapped into memory: is it empty?");
    try {
        const auto* bytes = static_cast<const char*>(map_);
        const Header head = parse<T>(path, std::string_view(bytes, map_bytes_), map_bytes_);
        shape_ = head.shape;
        values_ = {reinterpret_cast<const T*>(bytes + head.bytes), product(head.shape)};
    } catch (...) {
        munmap(map_, map_bytes_);
        throw;
    }
}

template <typename T>
MappedNpy<T>::~MappedNpy() {
    munmap(map_, map_bytes_);
}

template <typename T>
WritableNpy<T>::WritableNpy(const std::filesystem::path& path, const std::vector<std::size_t>& shape, bool keep) {
    const std::string head = header<T>(shape);
    map_bytes_ = head.size() + product(shape) * sizeof(T);
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | (keep ? 0 : O_TRUNC), 0666);
    if (file < 0) throw Error(path.string() + ": cannot be written: may you write there?");
    struct stat status {};
    if (keep && (fstat(file, &status) != 0 || static_cast<std::size_t>(status.st_size) != map_bytes_) &&
        ftruncate(file, 0) != 0)
        throw Error(path.string() + ": cannot be written: may you write there?");
    const bool has_room = posix_fallocate(file, 0, static_cast<off_t>(map_bytes_)) == 0;
    map_ = has_room ? mmap(nullptr, map_bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
    close(file);
    if (map_ == MAP_FAILED) throw Error(path.string() + ": cannot be written: is the disk full?");
    std::memcpy(map_, head.data(), head.size());
    values_ = {reinterpret_cast<T*>(static_cast<char*>(map_) + head.size()), product(shape)};
}

template <typename T>
WritableNpy<T>::~WritableNpy() {
    munmap(map_, map_bytes_);
}

template class WritableNpy<float>;
template class WritableNpy<double>;
template class WritableNpy<Half>;
template class NpyWriter<std::int32_t>;
template class NpyWriter<std::int16_t>;
template class NpyWriter<std::int8_t>;
template class NpyWriter<std::uint8_t>;
template class NpyWriter<Half>;
template class NpyWriter<float>;
template class NpyWriter<double>;
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const std::int32_t>);
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const std::int16_t>);
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const std::int8_t>);
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const std::uint8_t>);
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const float>);
template void write_npy(const std::filesystem::path&, const std::vector<std::size_t>&, std::span<const double>);
template Array<std::int32_t> read_npy(const std::filesystem::path&);
template Array<std::int16_t> read_npy(const std::filesystem::path&);
template Array<std::int8_t> read_npy(const std::filesystem::path&);
template Array<std::uint8_t> read_npy(const std::filesystem::path&);
template Array<float> read_npy(const std::filesystem::path&);
template Array<double> read_npy(const std::filesystem::path&);
template class MappedNpy<std::int32_t>;
template class MappedNpy<float>;
template class MappedNpy<Half>;
template class MappedNpy<double>;

}  // namespace haptable
