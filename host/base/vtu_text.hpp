// SPDX-License-Identifier: GPL-2.0-or-later
// An unstructured grid for ParaView: VTK's XML format, numbers as text,
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <type_traits>

namespace haptable {

/// The format's numbers of cell types.
enum VtkCell : std::uint8_t { kVtkVertex = 1, kVtkTriangle = 5, kVtkTetra = 10, kVtkQuadraticTetra = 24 };

/// The file's text, made in order: sections PointData, Points, CellData, Cells, each with its arrays.
class VtuText {
public:
    VtuText(std::size_t points, std::size_t cells) {
        line(R"(<?xml version="1.0"?>)");
        line(R"(<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">)");
        line("<UnstructuredGrid>");
        line(R"(<Piece NumberOfPoints="{}" NumberOfCells="{}">)", points, cells);
    }
    /// Ends the section before.
    void section(const char* name) {
        end_section();
        section_ = name;
        line("<{}>", section_);
    }
    /// type: VTK's, "Float32". lists: of numbers, or of what holds `components` numbers each; one after the other.
    template <typename... Lists>
    void array(const char* type, const char* name, int components, const Lists&... lists) {
        line(R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">)", type, name, components);
        (add(lists), ...);
        line("</DataArray>");
    }
    std::string finish() {
        end_section();
        line("</Piece>\n</UnstructuredGrid>\n</VTKFile>");
        return fmt::to_string(text_);
    }

private:
    template <typename... Args>
    void line(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
        text_.push_back('\n');
    }
    template <typename List>
    void add(const List& list) {
        for (const auto& item : list)
            if constexpr (std::is_arithmetic_v<std::decay_t<decltype(item)>>)
                line("{}", item);
            else
                line("{}", fmt::join(item, " "));
    }
    void end_section() {
        if (!section_.empty()) line("</{}>", section_);
    }

    fmt::memory_buffer text_;
    std::string section_;
};

}  // namespace haptable
