// SPDX-License-Identifier: GPL-2.0-or-later
// "VTK File Formats" of the VTK User's Guide, legacy: CELL_TYPES n, then n numbers; CELL_DATA n, then "VECTORS name
// type", or "name 3 n type" of a FIELD, and 3 n numbers. BINARY: big-endian.
#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <optional>

#include "host/base/error.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

/// The numbers that follow a line of a legacy file.
class VtkNumbers {
public:
    VtkNumbers(const std::filesystem::path& file, std::string_view text)
        : name_(file.string()), is_binary_(text.substr(0, 1024).find("\nBINARY") != std::string_view::npos) {}

    std::vector<double> read(std::string_view text, std::string_view type, std::size_t count) const {
        if (!is_binary_) return words(text, count);
        if (type == "float") return binary<float, std::uint32_t>(text, count);
        if (type == "double") return binary<double, std::uint64_t>(text, count);
        if (type == "int") return binary<std::int32_t, std::uint32_t>(text, count);
        throw Error(fmt::format("{}: vectors of type \"{}\" are not read; save them as float or double", name_, type));
    }

    [[noreturn]] void fail_short() const {
        throw Error(name_ + ": a list of numbers is cut off or damaged; save the mesh again");
    }

private:
    std::vector<double> words(std::string_view text, std::size_t count) const {
        std::vector<double> values;
        while (values.size() < count) {
            text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
            double value = 0.0;
            const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (failed != std::errc()) fail_short();
            text.remove_prefix(static_cast<std::size_t>(end - text.data()));
            values.push_back(value);
        }
        return values;
    }

    template <typename T, typename Bits>
    std::vector<double> binary(std::string_view text, std::size_t count) const {
        if (text.size() / sizeof(T) < count) fail_short();
        std::vector<double> values;
        for (std::size_t k = 0; k < count; ++k) {
            Bits bits = 0;
            for (std::size_t b = 0; b < sizeof(T); ++b)
                bits = static_cast<Bits>(bits << 8) | static_cast<unsigned char>(text[k * sizeof(T) + b]);
            values.push_back(static_cast<double>(std::bit_cast<T>(bits)));
        }
        return values;
    }

    std::string name_;
    bool is_binary_;
};

/// What follows the line that begins with `words`; nullopt where there is none. `line` is the rest of that line.
std::optional<std::string_view> behind(std::string_view text, const std::string& words, std::string& line) {
    const std::size_t at = text.find("\n" + words);
    if (at == std::string_view::npos) return {};
    const std::size_t begin = at + 1 + words.size(), end = text.find('\n', begin);
    if (end == std::string_view::npos) return {};
    line = text.substr(begin, end - begin);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    return text.substr(end + 1);
}

std::size_t count_of(const std::string& line) {
    std::size_t count = 0;
    std::from_chars(line.data(), line.data() + line.size(), count);
    return count;
}

/// Cells that are tetrahedra of either order.
std::vector<std::size_t> tets_of(const VtkNumbers& numbers, std::string_view text) {
    std::vector<std::size_t> tets;
    std::string line;
    const auto types = behind(text, "CELL_TYPES ", line);
    if (!types || count_of(line) > text.size()) return tets;
    const std::vector<double> type = numbers.read(*types, "int", count_of(line));
    for (std::size_t c = 0; c < type.size(); ++c)
        if (type[c] == 10.0 || type[c] == 24.0) tets.push_back(c);
    return tets;
}

}  // namespace

CellVectors read_vtk_vectors(const std::filesystem::path& file, std::string_view text,
                             std::span<const std::string> wanted) {
    CellVectors found;
    const VtkNumbers numbers(file, text);
    std::string line;
    const auto data = wanted.empty() ? std::nullopt : behind(text, "CELL_DATA ", line);
    const std::size_t cells = count_of(line);
    if (!data || cells > text.size()) return found;
    // The line's own end belongs to what is searched: the first list may follow at once.
    std::string_view section = text.substr(static_cast<std::size_t>(data->data() - text.data()) - 1);
    section = section.substr(0, section.find("\nPOINT_DATA "));
    const std::vector<std::size_t> tets = tets_of(numbers, text);
    for (const std::string& name : wanted) {
        std::string type;
        auto list = behind(section, "VECTORS " + name + " ", type);
        if (!list) list = behind(section, fmt::format("{} 3 {} ", name, cells), type);
        if (!list) continue;
        const std::vector<double> value = numbers.read(*list, type, 3 * cells);
        for (std::size_t c : tets) {
            if (c >= cells) numbers.fail_short();
            found[name].emplace_back(value[3 * c], value[3 * c + 1], value[3 * c + 2]);
        }
    }
    return found;
}

}  // namespace haptable
