// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <type_traits>

#include "host/base/program.hpp"

namespace haptable {

namespace {

/// Names `what` a number must be where `is` does not hold of it; what is no number at all the conversion names.
CLI::Validator number_that(const char* in_help, const char* what, bool (*is)(double)) {
    const auto test = [=](const std::string& text) {
        double value = 0.0;
        return !CLI::detail::lexical_cast(text, value) || is(value) ? std::string() : text + " must be " + what;
    };
    return CLI::Validator(test, in_help);
}

CLI::Validator finite_number() {
    return number_that("", "a finite number", [](double x) { return std::isfinite(x); });
}

}  // namespace

Option Option::required() const { return Option(option_->required()); }
Option Option::range(int least, int most) const { return Option(option_->check(CLI::Range(least, most))); }
Option Option::range(double least, double most) const { return Option(option_->check(CLI::Range(least, most))); }
Option Option::positive() const {
    return Option(option_->check(number_that("POSITIVE", "above 0", [](double x) { return x > 0.0; })));
}
Option Option::non_negative() const {
    return Option(option_->check(number_that("NONNEGATIVE", "0 or more", [](double x) { return x >= 0.0; })));
}
Option Option::one_of(std::initializer_list<int> values) const { return Option(option_->check(CLI::IsMember(values))); }
Option Option::delimiter(char between) const { return Option(option_->delimiter(between)); }
Option Option::count(int values) const { return Option(option_->expected(values)); }
Option Option::values_name(const char* in_help) const { return Option(option_->type_name(in_help)); }
Option Option::show_default() const { return Option(option_->capture_default_str()); }
Option Option::needs(const Option& other) const { return Option(option_->needs(other.option_)); }
Option Option::excludes(const Option& other) const { return Option(option_->excludes(other.option_)); }

template <typename T>
Option OptionSet::option(const std::string& name, T& value, const std::string& help) {
    CLI::Option* option = app_->add_option(name, value, help);
    if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::vector<double>>) option->check(finite_number());
    return Option(option);
}

Option OptionSet::flag(const std::string& name, bool& value, const std::string& help) {
    return Option(app_->add_flag(name, value, help));
}

Option OptionSet::numbers(const std::string& name, const std::function<void(const std::vector<double>&)>& set,
                          const std::string& help) {
    return Option(app_->add_option_function(name, set, help)->check(finite_number()));
}

CommandLine::CommandLine(const std::string& what, const std::string& program)
    : OptionSet(nullptr), program_(program), owned_(std::make_unique<CLI::App>(what, program)) {
    app_ = owned_.get();
}

CommandLine::~CommandLine() = default;

ExclusiveOptions CommandLine::exclusive(const std::string& name, const std::string& help) {
    auto* group = app_->add_option_group(name, help);
    group->require_option(1);
    return ExclusiveOptions(group);
}

bool CommandLine::parse(int argc, char** argv) try {
    app_->set_version_flag("--version", program_ + " " + kVersion);  // last in --help
    app_->parse(argc, argv);
    return true;
} catch (const CLI::Success& success) {
    app_->exit(success);
    return false;
} catch (const CLI::ParseError& error) {
    throw BadCommandLine(std::string(error.what()) + " (see --help)");
}

// Each type of value costs the time to compile CLI11's templates for it once.
template Option OptionSet::option(const std::string&, std::string&, const std::string&);
template Option OptionSet::option(const std::string&, std::filesystem::path&, const std::string&);
template Option OptionSet::option(const std::string&, double&, const std::string&);
template Option OptionSet::option(const std::string&, int&, const std::string&);
template Option OptionSet::option(const std::string&, unsigned&, const std::string&);
template Option OptionSet::option(const std::string&, std::int64_t&, const std::string&);
template Option OptionSet::option(const std::string&, std::size_t&, const std::string&);
template Option OptionSet::option(const std::string&, std::vector<int>&, const std::string&);
template Option OptionSet::option(const std::string&, std::vector<std::int64_t>&, const std::string&);
template Option OptionSet::option(const std::string&, std::vector<double>&, const std::string&);
template Option OptionSet::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option OptionSet::option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);

}  // namespace haptable
