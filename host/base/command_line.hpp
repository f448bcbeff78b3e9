// SPDX-License-Identifier: GPL-2.0-or-later
// A program's options, read by CLI11. Its headers cost ten seconds a file, so that only command_line.cpp includes them.
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "host/base/error.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace haptable {

/// What CommandLine::parse throws: the program ends with 2.
class BadCommandLine : public Error {
    using Error::Error;
};

/// What is said of one option after its declaration; a command line that breaks it is a bad one.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}
    Option required() const;
    Option range(int least, int most) const;
    Option range(double least, double most) const;
    Option positive() const;
    Option non_negative() const;
    Option one_of(std::initializer_list<int> values) const;
    Option delimiter(char between) const;           ///< of the values of a list in one word: "8,12,16"
    Option count(int values) const;                 ///< words that the option takes
    Option values_name(const char* in_help) const;  ///< instead of the values' type
    Option show_default() const;                    ///< --help prints the value that the variable has now
    Option needs(const Option& other) const;
    Option excludes(const Option& other) const;

private:
    CLI::Option* option_;
};

/// Options that set variables, which outlive the parsing. Names as CLI11 takes them: "DIR" (by place), "-o,--out",
/// "!--no-such" (sets a flag to false).
class OptionSet {
public:
    /// T: std::string, std::filesystem::path, a number, or a vector of them, as listed at the end of command_line.cpp.
    template <typename T>
    Option option(const std::string& name, T& value, const std::string& help);
    Option flag(const std::string& name, bool& value, const std::string& help);
    /// Hands its numbers to `set`.
    Option numbers(const std::string& name, const std::function<void(const std::vector<double>&)>& set,
                   const std::string& help);

protected:
    explicit OptionSet(CLI::App* app) : app_(app) {}
    CLI::App* app_;
};

/// Exactly one of these options must be given.
class ExclusiveOptions : public OptionSet {
    friend class CommandLine;
    using OptionSet::OptionSet;
};

/// The command line of a program: --help and --version besides its own options.
class CommandLine : public OptionSet {
public:
    CommandLine(const std::string& what, const std::string& program);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    ExclusiveOptions exclusive(const std::string& name, const std::string& help);
    const std::string& program() const { return program_; }

    /// Sets the variables. False: --help or --version, which is printed, was all that was asked for.
    bool parse(int argc, char** argv);

private:
    std::string program_;
    std::unique_ptr<CLI::App> owned_;
};

}  // namespace haptable
