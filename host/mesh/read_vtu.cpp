// SPDX-License-Identifier: GPL-2.0-or-later
// VTK XML, "VTK File Formats" of the VTK User's Guide: <DataArray> holds numbers as text, as base64 of [bytes][data]
// or, with a compressor, of [blocks][block bytes][last block bytes][compressed bytes ...] and then the blocks.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <pugixml.hpp>

#include "host/base/error.hpp"
#include "host/mesh/lines.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

// zlib cannot expand more than this (zlib's technical details): larger promises are lies.
constexpr std::size_t kMostExpansion = 1032;

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Decodes until '=' or the end of what is base64. `at` moves behind what was read, padding included.
std::string decode_base64(std::string_view text, std::size_t& at, std::size_t most_bytes) {
    std::string bytes;
    std::uint32_t bits = 0;
    int filled = 0;
    for (; at < text.size() && bytes.size() < most_bytes; ++at) {
        const int digit = base64_digit(text[at]);
        if (text[at] == ' ' || text[at] == '\n' || text[at] == '\r' || text[at] == '\t') continue;
        if (digit < 0) break;
        bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xffffff;
        filled += 6;
        if (filled < 8) continue;
        filled -= 8;
        bytes.push_back(static_cast<char>(bits >> filled & 0xff));
    }
    while (at < text.size() && text[at] == '=') ++at;
    return bytes;
}

class VtuReader {
public:
    VtuReader(const std::filesystem::path& file, std::string_view text, std::span<const std::string> vectors)
        : name_(file.string()), wanted_(vectors) {
        // What is appended may be raw bytes, which no parser of XML takes: it is cut off first.
        const std::size_t appended = text.find("<AppendedData");
        std::string xml(text.substr(0, appended));
        if (appended != std::string_view::npos) {
            raw_appended_ = text.substr(appended, 200).find("\"raw\"") != std::string_view::npos;
            const std::size_t mark = text.find('_', text.find('>', appended));
            appended_ = mark == std::string_view::npos ? std::string_view() : text.substr(mark + 1);
            xml += "</VTKFile>";
        }
        const pugi::xml_parse_result parsed = xml_.load_buffer(xml.data(), xml.size());
        if (!parsed)
            fail(fmt::format("its XML is damaged at byte {}: {}; save it again", parsed.offset, parsed.description()));
    }

    RawMesh read() {
        const pugi::xml_node root = xml_.child("VTKFile");
        const std::string type = root.attribute("type").as_string();
        if (type != "UnstructuredGrid") fail(fmt::format("is VTK XML of type {}, not UnstructuredGrid", type));
        swap_ = (std::string(root.attribute("byte_order").as_string("LittleEndian")) == "BigEndian") !=
                (std::endian::native == std::endian::big);
        wide_ = std::string(root.attribute("header_type").as_string("UInt32")) == "UInt64";
        const std::string compressor = root.attribute("compressor").as_string();
        zlib_ = compressor == "vtkZLibDataCompressor";
        if (!compressor.empty() && !zlib_) fail(fmt::format("is compressed by {}; save it with zlib", compressor));
        for (const pugi::xml_node piece : root.child(type.c_str()).children("Piece")) read_piece(piece);
        return std::move(raw_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

    void read_piece(const pugi::xml_node& piece) {
        const Tag base = raw_.node_tag.size();
        const std::vector<double> points = array(piece.child("Points").child("DataArray"), "Points");
        if (points.size() % 3 != 0) fail("its points are not three numbers each");
        for (std::size_t k = 0; k + 2 < points.size(); k += 3) {
            raw_.node_tag.push_back(raw_.node_tag.size());
            raw_.position.emplace_back(points[k], points[k + 1], points[k + 2]);
        }
        const pugi::xml_node cells = piece.child("Cells");
        const auto named = [&](const char* key) {
            return array(cells.find_child_by_attribute("DataArray", "Name", key), key);
        };
        const std::vector<double> node = named("connectivity"), end = named("offsets"), type = named("types");
        read_vectors(piece, type);
        if (end.size() != type.size())
            fail(fmt::format("has {} offsets and {} types of cells; save it again", end.size(), type.size()));
        for (std::size_t c = 0, first = 0; c < type.size(); ++c) {
            const double last = end[c];
            if (!(last >= static_cast<double>(first)) || !(last <= static_cast<double>(node.size())))
                fail(fmt::format("cell {} ends at {} of {} numbers in connectivity; save it again", c, last,
                                 node.size()));
            if (!(type[c] >= 0.0 && type[c] <= 255.0)) fail(fmt::format("cell {} is of no type: {}", c, type[c]));
            add_cell(static_cast<int>(type[c]), node, first, static_cast<std::size_t>(last), base);
            first = static_cast<std::size_t>(last);
        }
    }

    /// Reads the vectors of the tetrahedra among the cells.
    void read_vectors(const pugi::xml_node& piece, const std::vector<double>& type) {
        for (const std::string& name : wanted_) {
            const pugi::xml_node data =
                piece.child("CellData").find_child_by_attribute("DataArray", "Name", name.c_str());
            if (!data || data.attribute("NumberOfComponents").as_int(1) != 3) continue;
            const std::vector<double> value = array(data, name.c_str());
            if (value.size() != 3 * type.size())
                fail(fmt::format("has {} numbers in \"{}\" for {} cells; save it again", value.size(), name,
                                 type.size()));
            for (std::size_t c = 0; c < type.size(); ++c)
                if (type[c] == 10.0 || type[c] == 24.0)
                    raw_.vectors[name].emplace_back(value[3 * c], value[3 * c + 1], value[3 * c + 2]);
        }
    }

    void add_cell(int type, const std::vector<double>& node, std::size_t first, std::size_t last, Tag base) {
        const Tag tag = cell_++;
        if (type == 10 || type == 24) {
            if (last - first != (type == 10 ? 4U : 10U))
                fail(fmt::format("cell {}, a tetrahedron, has {} nodes; save it again", tag, last - first));
            std::vector<Tag> tags;
            for (std::size_t k = first; k < last; ++k) {
                if (!(node[k] >= 0.0 && node[k] < 9e15)) fail(fmt::format("cell {} names node {}", tag, node[k]));
                tags.push_back(base + static_cast<Tag>(node[k]));
            }
            raw_.add_tet(tag, tags);
        } else if (type == 5 || type == 6 || type == 7 || type == 8 || type == 9 || type == 22 || type == 23 ||
                   type == 28) {
            ++raw_.surface_elements;
        } else if (type > 4 && type != 21) {  // 1 to 4 and 21: points and lines
            raw_.add_other(type == 12 ? "hexahedron" : fmt::format("VTK cell {}", type), tag);
        }
    }

    std::vector<double> array(const pugi::xml_node& data, const char* what) const {
        if (!data) fail(fmt::format("has no {}; save it again", what));
        const std::string format = data.attribute("format").as_string("ascii");
        if (format == "ascii") return text_numbers(data.text().get());
        const std::string_view inside = data.text().get();
        if (format == "binary") return numbers(data, unpack(inside, false));
        const auto offset = static_cast<std::size_t>(data.attribute("offset").as_ullong());
        if (format != "appended" || offset >= appended_.size()) fail(fmt::format("the data of {} are missing", what));
        return numbers(data, unpack(appended_.substr(offset), raw_appended_));
    }

    std::vector<double> text_numbers(std::string_view text) const {
        std::vector<double> values;
        Lines in(name_, text);
        while (in.next())
            for (std::size_t k = 0; k < in.size(); ++k) values.push_back(in.real(k));
        return values;
    }

    /// One number of a header.
    std::uint64_t header(const std::string& bytes, std::size_t k) const {
        const std::size_t width = wide_ ? 8 : 4;
        if ((k + 1) * width > bytes.size()) fail("a block of data is cut off; save it again");
        std::uint64_t value = 0;
        for (std::size_t b = 0; b < width; ++b) {
            const std::size_t place = swap_ == (std::endian::native == std::endian::little) ? width - 1 - b : b;
            value |= std::uint64_t{static_cast<unsigned char>(bytes[k * width + place])} << (8 * b);
        }
        return value;
    }

    /// The next `count` bytes of the stream, base64 or raw.
    std::string take(std::string_view text, std::size_t& at, std::size_t count, bool raw) const {
        std::string bytes =
            raw ? std::string(text.substr(std::min(at, text.size()), count)) : decode_base64(text, at, count);
        if (raw) at += bytes.size();
        if (bytes.size() < count)
            fail(fmt::format("a block promises {} bytes and the file has {}; it is cut off", count, bytes.size()));
        return bytes;
    }

    std::string unpack(std::string_view text, bool raw) const {
        const std::size_t width = wide_ ? 8 : 4;
        while (!raw && !text.empty() && base64_digit(text[0]) < 0) text.remove_prefix(1);
        if (text.empty()) return {};
        std::size_t at = 0;
        if (!zlib_) {
            // Header and data are one stream of base64: decoded together.
            std::size_t probe = 0;
            const std::string first = take(text, probe, width, raw);
            const std::uint64_t bytes = header(first, 0);
            if (bytes > text.size()) fail(fmt::format("a block promises {} bytes, more than the file has", bytes));
            return take(text, at, width + static_cast<std::size_t>(bytes), raw).substr(width);
        }
        return inflate_blocks(text, raw, width);
    }

    std::string inflate_blocks(std::string_view text, bool raw, std::size_t width) const {
        std::size_t at = 0;
        const std::uint64_t blocks = header(take(text, at, width, raw), 0);
        if (blocks > text.size() / width) fail(fmt::format("promises {} blocks, more than the file has", blocks));
        at = 0;
        const std::string head = take(text, at, (3 + static_cast<std::size_t>(blocks)) * width, raw);
        const std::uint64_t full = header(head, 1), partial = header(head, 2);
        std::uint64_t packed = 0;
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::uint64_t bytes = header(head, 3 + b);
            const std::uint64_t size = b + 1 == blocks && partial != 0 ? partial : full;
            if (bytes > text.size() || size / kMostExpansion > bytes + 1)
                fail(fmt::format("block {} promises {} bytes, more than the file has", b, std::max(bytes, size)));
            packed += bytes;
        }
        if (packed > text.size()) fail(fmt::format("promises {} bytes of blocks, more than the file has", packed));
        const std::string data = take(text, at, static_cast<std::size_t>(packed), raw);
        std::string all;
        for (std::size_t b = 0, from = 0; b < blocks; ++b) {
            const std::uint64_t size = b + 1 == blocks && partial != 0 ? partial : full;
            const auto bytes = static_cast<std::size_t>(header(head, 3 + b));
            inflate(data.substr(from, bytes), static_cast<std::size_t>(size), all);
            from += bytes;
        }
        return all;
    }

    void inflate(const std::string& packed, std::size_t size, std::string& all) const {
        const std::size_t begin = all.size();
        all.resize(begin + size);
        uLongf written = size;
        const int status = uncompress(reinterpret_cast<Bytef*>(all.data() + begin), &written,
                                      reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
        if (status != Z_OK || written != size) fail("a compressed block is damaged; save it again");
    }

    template <typename T>
    std::vector<double> convert(const std::string& bytes) const {
        std::vector<double> values;
        for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
            char one[sizeof(T)];
            std::memcpy(one, bytes.data() + at, sizeof(T));
            if (swap_) std::reverse(one, one + sizeof(T));
            T value;
            std::memcpy(&value, one, sizeof(T));
            values.push_back(static_cast<double>(value));
        }
        return values;
    }

    std::vector<double> numbers(const pugi::xml_node& data, const std::string& bytes) const {
        const std::string type = data.attribute("type").as_string();
        if (type == "Float32") return convert<float>(bytes);
        if (type == "Float64") return convert<double>(bytes);
        if (type == "Int8") return convert<std::int8_t>(bytes);
        if (type == "UInt8") return convert<std::uint8_t>(bytes);
        if (type == "Int16") return convert<std::int16_t>(bytes);
        if (type == "UInt16") return convert<std::uint16_t>(bytes);
        if (type == "Int32") return convert<std::int32_t>(bytes);
        if (type == "UInt32") return convert<std::uint32_t>(bytes);
        if (type == "Int64") return convert<std::int64_t>(bytes);
        if (type == "UInt64") return convert<std::uint64_t>(bytes);
        fail(fmt::format("has numbers of type \"{}\"; save it again", type));
    }

    std::string name_;
    std::span<const std::string> wanted_;
    pugi::xml_document xml_;
    std::string_view appended_;
    bool raw_appended_ = false, swap_ = false, wide_ = false, zlib_ = false;
    RawMesh raw_;
    Tag cell_ = 0;
};

}  // namespace

bool is_vtu(const MeshFile& file) { return file.head.find("<VTKFile") != std::string_view::npos; }

RawMesh read_vtu(const MeshFile& file) { return VtuReader(file.path, file.text, file.vectors).read(); }

}  // namespace haptable
