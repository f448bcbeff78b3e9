// SPDX-License-Identifier: GPL-2.0-or-later
// Abaqus Analysis User's Guide, 1.2.1 (input syntax), *NODE, *ELEMENT, *NSET, *ELSET: keyword lines begin with '*',
// comments with "**", keywords and labels in either case.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <unordered_map>

#include "host/base/text.hpp"
#include "host/mesh/lines.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

class AbaqusReader {
public:
    AbaqusReader(const std::filesystem::path& file, std::string_view text) : in_(file, text) {}

    RawMesh read() {
        while (in_.next('\0')) {
            if (in_.line().substr(0, 2) == "**") continue;
            if (in_.fields()[0][0] == '*')
                keyword();
            else
                data();
        }
        name_sets();
        return std::move(raw_);
    }

private:
    /// "*ELEMENT, TYPE=C3D4, ELSET=EB1": upper case, blanks around '=' and ',' gone.
    void keyword() {
        std::string line = upper(in_.line());
        line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t'; }), line.end());
        word_ = line.substr(0, line.find(','));
        type_ = parameter(line, "TYPE");
        set_ = parameter(line, word_ == "*ELEMENT" || word_ == "*ELSET" ? "ELSET" : "NSET");
        generate_ = line.find(",GENERATE") != std::string::npos;
        if (word_ == "*INCLUDE") in_.fail("*INCLUDE is not followed; put its content here");
    }
    static std::string parameter(const std::string& line, const std::string& name) {
        const std::size_t at = line.find("," + name + "=");
        if (at == std::string::npos) return {};
        const std::size_t begin = at + name.size() + 2;
        return line.substr(begin, line.find(',', begin) - begin);
    }

    void data() {
        if (word_ == "*NODE") {
            raw_.node_tag.push_back(in_.whole(0, "a node's number"));
            raw_.position.emplace_back(in_.real(1), in_.real(2), in_.size() > 3 ? in_.real(3) : 0.0);
            if (!set_.empty()) raw_.group[set_].node.push_back(raw_.node_tag.back());
        } else if (word_ == "*ELEMENT") {
            element();
        } else if (word_ == "*NSET" || word_ == "*ELSET") {
            set_line();
        } else if (word_ == "*INSTANCE" || word_ == "*SYSTEM") {
            in_.fail(word_ + " moves its part, which is not done here; write the mesh in one system");
        }
    }

    void element() {
        const Tag tag = in_.whole(0, "an element's number");
        const bool second = type_.starts_with("C3D10");
        if (!second && !type_.starts_with("C3D4")) {
            if (type_.starts_with("C3D")) raw_.add_other(type_, tag);
            if (type_.starts_with("C3D") && in_.line().back() == ',') in_.require("the element's other nodes", '\0');
            if (!type_.starts_with("C3D")) ++raw_.surface_elements;
            return;
        }
        std::vector<Tag> node;
        for (std::size_t k = 1; k < in_.size(); ++k) node.push_back(in_.whole(k, "a node's number"));
        while (second && node.size() < 10) {  // a record of ten nodes may be broken after a comma
            in_.require("the element's other nodes", '\0');
            for (std::size_t k = 0; k < in_.size(); ++k) node.push_back(in_.whole(k, "a node's number"));
        }
        if (node.size() != (second ? 10U : 4U))
            in_.fail(fmt::format("element {} of type {} has {} nodes; save the mesh again", tag, type_, node.size()));
        if (!set_.empty()) raw_.group[set_].tet.push_back(raw_.tet.size());
        raw_.add_tet(tag, node);
    }

    /// Numbers, a range "first, last, step", or names of other sets (which are not followed).
    void set_line() {
        std::vector<Tag>& into = word_ == "*NSET" ? raw_.group[set_].node : element_set_[set_];
        if (generate_) {
            const Tag first = in_.whole(0, "a number"), last = in_.whole(1, "a number");
            const Tag step = in_.size() > 2 ? std::max<Tag>(1, in_.whole(2, "a step")) : 1;
            const std::size_t most = raw_.node_tag.size() + raw_.tet.size() + 1;
            if (last < first || (last - first) / step > 1000 * most) in_.fail("this range is larger than the mesh");
            for (Tag k = first; k <= last && k >= first; k += step) into.push_back(k);
            return;
        }
        for (std::size_t k = 0; k < in_.size(); ++k) {
            if (!std::isdigit(static_cast<unsigned char>(in_.fields()[k][0])))
                in_.fail(fmt::format("set {} names another set; give its numbers", set_));
            into.push_back(in_.whole(k, "a number"));
        }
    }

    /// Sets of elements name numbers: turned into places once all elements are there.
    void name_sets() {
        std::unordered_map<Tag, std::size_t> place;
        for (std::size_t t = 0; t < raw_.tet.size(); ++t) place.emplace(raw_.tet_tag[t], t);
        for (const auto& [name, tags] : element_set_)
            for (Tag tag : tags)
                if (const auto at = place.find(tag); at != place.end()) raw_.group[name].tet.push_back(at->second);
    }

    Lines in_;
    RawMesh raw_;
    std::string word_, type_, set_;
    bool generate_ = false;
    std::map<std::string, std::vector<Tag>> element_set_;
};

}  // namespace

bool is_abaqus(const MeshFile& file) {
    const std::string small = lower(file.head);
    return small.starts_with("*") &&
           (small.find("*node") != std::string::npos || small.find("*heading") != std::string::npos);
}

RawMesh read_abaqus(const MeshFile& file) { return AbaqusReader(file.path, file.text).read(); }

}  // namespace haptable
