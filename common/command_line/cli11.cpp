// The only file that includes CLI11: what command.h and check.h declare, and --help.

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "common/command_line/command.h"
#include "common/command_line/command_table.h"
#include "common/command_line/option_words.h"
#include "common/command_line/toml.h"
#include "common/command_line/write_manuals.h"
#include "common/process/print.h"
#include "pointreel/version.h"

namespace pointreel::cli {
namespace {

/// Whether it has no other name than its place. Those that have both stand among the options.
bool is_argument(const CLI::Option& option) {
  return option.get_positional() && option.get_snames().empty() && option.get_lnames().empty();
}

OptionEntry entry_of(const CLI::Option& option) {
  OptionEntry entry;
  entry.positional = is_argument(option);
  entry.has_place = option.get_positional();
  if (entry.positional) entry.names.push_back(option.get_single_name());
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  entry.type = option.get_type_name();
  entry.least_values = option.get_items_expected_min();
  entry.most_values = option.get_items_expected_max();
  entry.description = option.get_description();
  entry.preset = option.get_default_str();
  entry.variable = option.get_envname();
  entry.group = option.get_group();
  entry.required = option.get_required();
  for (const CLI::Option* needed : option.get_needs()) entry.needs.push_back(needed->get_name());
  return entry;
}

/// Prints --help in 80 columns: the names of an option and its argument on the left, and on the
/// right what option_words.h says about it.
class HelpFormatter : public CLI::Formatter {
 public:
  /// --help of `command` shows its essentials, and that of others all options.
  explicit HelpFormatter(const CLI::App* command = nullptr) : command_(command) {
    column_width(kColumn);
    label("Positionals", "Arguments");
  }

  bool is_of(const CLI::App& app) const { return command_ == &app; }
  void add_essentials(const std::vector<std::string>& names) {
    essentials_.insert(essentials_.end(), names.begin(), names.end());
  }

  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    const std::string text = CLI::Formatter::make_group(group, is_positional, std::move(options));
    // CLI11 puts two empty lines between groups, but one before the first.
    return is_positional || group == "Options" ? text : text.substr(1);
  }

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    // Commands inherit the formatter of the command above them.
    if (mode != CLI::AppFormatMode::Normal || !is_of(*app))
      return CLI::Formatter::make_help(app, std::move(name), mode);
    std::vector<const CLI::Option*> shown = {app->get_help_ptr(), app->get_help_all_ptr()};
    for (const std::string& essential : essentials_) shown.push_back(app->get_option(essential));
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) +
           make_group("Options", false, std::move(shown)) + make_subcommands(app, mode) + "\n" +
           make_footer(app);
  }

  /// For --help-all of a program, its commands with their options; for that of a command, a list.
  std::string make_subcommands(const CLI::App* app, CLI::AppFormatMode mode) const override {
    return CLI::Formatter::make_subcommands(
        app, app->get_parent() == nullptr ? mode : CLI::AppFormatMode::Normal);
  }

  std::string make_positionals(const CLI::App* app) const override {
    std::vector<const CLI::Option*> arguments = app->get_options([](const CLI::Option* option) {
      return !option->get_group().empty() && option->get_positional();
    });
    return arguments.empty() ? "" : make_group(get_label("Positionals"), true, arguments);
  }

  /// Options that may be given without their names stand among the arguments, too.
  std::string make_option(const CLI::Option* option, bool as_argument) const override {
    if (!as_argument || is_argument(*option)) return CLI::Formatter::make_option(option, false);
    std::ostringstream out;
    CLI::detail::format_help(out, option->get_name(true), "The same as " + option->get_name(),
                             kColumn);
    return out.str();
  }

  std::string make_option_name(const CLI::Option* option, bool) const override {
    return fmt::format("{}", fmt::join(entry_of(*option).names, ", "));
  }

  /// By its place.
  std::string make_option_usage(const CLI::Option* option) const override {
    std::string name = option->get_name(true);
    if (option->get_expected_max() > 1) name += "...";
    return option->get_required() ? name : "[" + name + "]";
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string argument = argument_of(entry_of(*option));
    return argument.empty() ? "" : " " + argument;
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrap(description_of(entry_of(*option)), 80 - kColumn);
  }

  std::string make_description(const CLI::App* app) const override {
    std::istringstream lines(app->get_description());
    std::string text;
    int number = 0;
    for (std::string line; std::getline(lines, line); ++number) {
      // The first line of a command's description is its heading (make_subcommand).
      if (number == 1 && app->get_parent() != nullptr) text += "\n";
      text += wrap(line, 80) + "\n";
    }
    return text + "\n";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    // The first line of a description says what a command is for.
    const std::string text = command->get_description();
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(),
                             wrap(text.substr(0, text.find('\n')), 80 - kColumn), kColumn);
    return out.str();
  }

 private:
  static constexpr std::size_t kColumn = 26;

  const CLI::App* command_;
  std::vector<std::string> essentials_;
};

/// Null unless the command has essentials.
HelpFormatter* own_formatter(const CLI::App& app) {
  auto* formatter = dynamic_cast<HelpFormatter*>(app.get_formatter().get());
  return formatter != nullptr && formatter->is_of(app) ? formatter : nullptr;
}

/// What follows the name of the program in the line "Usage:".
std::string usage_of(const CLI::App& app) {
  const std::string usage = HelpFormatter().make_usage(&app, "");
  const std::size_t begin = usage.find('[');
  return usage.substr(begin, usage.find('\n', begin) - begin);
}

/// Adds the entries of a command and of those below it.
void add_entries(std::vector<CommandEntry>& all, const CLI::App& app,
                 std::vector<std::string> path) {
  path.push_back(app.get_name());
  CommandEntry command{path, app.get_description(), usage_of(app), app.get_footer(), {}, {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (is_argument(*option) ? command.arguments : command.options).push_back(entry_of(*option));
  }
  const CLI::App* above = app.get_parent();
  if (above != nullptr && app.get_fallthrough() && above->get_config_ptr() != nullptr)
    command.options.push_back(entry_of(*above->get_config_ptr()));
  const std::vector<const CLI::App*> below = app.get_subcommands({});
  for (const CLI::App* subcommand : below)
    command.subcommands.push_back(
        {subcommand->get_name(), summary_of(subcommand->get_description())});
  all.push_back(std::move(command));
  for (const CLI::App* subcommand : below) add_entries(all, *subcommand, path);
}

/// CLI11 takes "[a,b]" for two values, and "[a]" for "a", where an option takes several; but a
/// folder may have such a name. This character before the bracket keeps CLI11 from it until the
/// value is checked.
constexpr char kShield = '\x01';

/// `begin`: where the value begins.
std::string shielded(std::string text, std::size_t begin = 0) {
  if (begin < text.size() && (text[begin] == '[' || text[begin] == kShield))
    text.insert(begin, 1, kShield);
  return text;
}

std::vector<std::string> shielded(std::vector<std::string> values) {
  for (std::string& value : values) value = shielded(std::move(value));
  return values;
}

/// The arguments of a command line, the last one first, as CLI11 takes them.
std::vector<std::string> last_first(const std::vector<std::string>& arguments) {
  std::vector<std::string> all;
  bool may_be_option = true;
  for (const std::string& argument : arguments) {
    may_be_option &= argument != "--";
    const bool is_long = may_be_option && argument.starts_with("--");
    if (const std::size_t equals = argument.find('='); is_long && equals + 1 == argument.size()) {
      // CLI11 would take the next argument for its value.
      all.insert(all.end(), {argument.substr(0, equals), ""});
    } else if (is_long) {
      all.push_back(shielded(argument, equals == std::string::npos ? argument.size() : equals + 1));
    } else {
      all.push_back(shielded(argument, may_be_option && argument.starts_with('-') ? 2 : 0));
    }
  }
  std::reverse(all.begin(), all.end());
  return all;
}

/// An option whose values are those that were given.
Option unshielded(CLI::Option* option) {
  const auto take_away = [](std::string& value) {
    if (const auto at = value.find(kShield); at == 0 || (at < value.size() && value[at + 1] == '['))
      value.erase(at, 1);
    return std::string();
  };
  return Option(option->transform(CLI::Validator(take_away, "")));
}

template <class Object>
std::vector<Command> handles_of(const std::vector<Object*>& apps) {
  return {apps.begin(), apps.end()};
}

}  // namespace

template <class T>
Check range(T least, T most) {
  const CLI::Range range(least, most);
  return {range, range.get_description()};
}

template Check range(int, int);
template Check range(unsigned, unsigned);
template Check range(std::size_t, std::size_t);
template Check range(double, double);

Check one_of(const std::vector<std::string>& words) {
  const CLI::IsMember member(words);
  return {member, member.get_description()};
}

Check existing_file() { return {CLI::ExistingFile, CLI::ExistingFile.get_description()}; }

std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  return CLI::detail::lexical_cast(text, value) ? std::optional(value) : std::nullopt;
}

Option Option::allow_extra_args(bool allow) const {
  return Option(option_->allow_extra_args(allow));
}
Option Option::capture_default_str() const { return Option(option_->capture_default_str()); }
Option Option::check(const Check& check) const {
  return Option(option_->check(check.fault, check.accepts));
}
Option Option::default_str(const std::string& text) const {
  return Option(option_->default_str(text));
}
Option Option::description(const std::string& text) const {
  return Option(option_->description(text));
}
Option Option::envname(const std::string& name) const { return Option(option_->envname(name)); }
Option Option::excludes(Option other) const { return Option(option_->excludes(other.option_)); }
Option Option::expected(int least, int most) const {
  return Option(option_->expected(least, most));
}
Option Option::group(const std::string& name) const { return Option(option_->group(name)); }
Option Option::in_bytes() const { return Option(option_->transform(CLI::AsSizeValue(false))); }
Option Option::needs(Option other) const { return Option(option_->needs(other.option_)); }
Option Option::required(bool required) const { return Option(option_->required(required)); }
Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }

std::size_t Option::count() const { return option_->count(); }
std::string Option::value() const { return option_->as<std::string>(); }
const std::vector<std::string>& Option::values() const { return option_->results(); }
std::string Option::name() const { return option_->get_name(); }
std::string Option::envname() const { return option_->get_envname(); }
bool Option::is_flag() const { return option_->get_items_expected_max() == 0; }

template <class T>
Option Command::add_option(const std::string& names, T& value,
                           const std::string& description) const {
  return unshielded(app_->add_option(names, value, description));
}

using Words = std::vector<std::string>;
using Paths = std::vector<std::filesystem::path>;
using Text = const std::string&;

template Option Command::add_option(Text, int&, Text) const;
template Option Command::add_option(Text, std::uint16_t&, Text) const;
template Option Command::add_option(Text, unsigned&, Text) const;
template Option Command::add_option(Text, std::size_t&, Text) const;
template Option Command::add_option(Text, double&, Text) const;
template Option Command::add_option(Text, std::optional<std::size_t>&, Text) const;
template Option Command::add_option(Text, std::optional<double>&, Text) const;
template Option Command::add_option(Text, std::vector<double>&, Text) const;
template Option Command::add_option(Text, std::string&, Text) const;
template Option Command::add_option(Text, Words&, Text) const;
template Option Command::add_option(Text, std::filesystem::path&, Text) const;
template Option Command::add_option(Text, std::optional<std::filesystem::path>&, Text) const;
template Option Command::add_option(Text, Paths&, Text) const;

template <class T>
Option Command::add_option_function(const std::string& names,
                                    const std::function<void(const T&)>& set,
                                    const std::string& description) const {
  return unshielded(app_->add_option_function(names, set, description));
}

template Option Command::add_option_function(Text, const std::function<void(const int&)>&,
                                             Text) const;
template Option Command::add_option_function(Text, const std::function<void(const double&)>&,
                                             Text) const;
template Option Command::add_option_function(Text, const std::function<void(const std::string&)>&,
                                             Text) const;
template Option Command::add_option_function(Text, const std::function<void(const Words&)>&,
                                             Text) const;

Option Command::add_option(const std::string& names) const {
  return unshielded(app_->add_option(names));
}
Option Command::add_flag(const std::string& names, bool& value,
                         const std::string& description) const {
  return Option(app_->add_flag(names, value, description));
}
Option Command::add_flag(const std::string& names) const { return Option(app_->add_flag(names)); }
Option Command::add_flag_callback(const std::string& names, const std::function<void()>& set,
                                  const std::string& description) const {
  return Option(app_->add_flag_callback(names, set, description));
}

namespace {

/// The options of a command in a file: those below the line [COMMAND].
class ConfigFile : public CLI::Config {
 public:
  explicit ConfigFile(const CLI::App& command) : command_(command) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    // One byte more than parse_toml takes, of files that have no end.
    std::string text((std::size_t{1} << 20) + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    auto settings = parse_toml(text);
    if (!settings) throw CLI::ConfigError("--config: " + settings.error().message);
    std::ranges::stable_sort(*settings, {}, &TomlSetting::line);  // the first fault is told
    std::vector<CLI::ConfigItem> given;
    for (const TomlSetting& setting : *settings) {
      if (const std::string fault = fault_of(setting); !fault.empty())
        throw CLI::ConfigError(fmt::format("--config: line {}: {}", setting.line, fault));
      // An empty list gives nothing, and CLI11 takes it for an option without its argument.
      if (!setting.values.empty())
        given.push_back({{setting.table}, setting.name, shielded(setting.values)});
    }
    return given;
  }

  std::string to_config(const CLI::App*, bool, bool, std::string) const override { return {}; }

 private:
  std::string fault_of(const TomlSetting& setting) const {
    if (setting.table != command_.get_name())
      return fmt::format("this stands below no line [{0}], and only {0} reads options from a file",
                         command_.get_name());
    const CLI::Option* option = command_.get_option_no_throw("--" + setting.name);
    if (option == nullptr) option = command_.get_option_no_throw(setting.name);
    if (option == nullptr) return fmt::format("{} has no option {}", setting.table, setting.name);
    if ((option->get_items_expected_max() == 0) != setting.is_flag)
      return setting.is_flag ? setting.name + " takes a value, not true or false"
                             : setting.name + " is true or false";
    if (setting.values.size() > 1 && option->get_items_expected_max() == 1)
      return setting.name + " takes one value, not a list";
    return {};
  }

  const CLI::App& command_;
};

}  // namespace

Option Command::add_config(const std::string& names, const std::string& description) const {
  CLI::App& program = *app_->get_parent();
  program.config_formatter(std::make_shared<ConfigFile>(*app_));
  for (CLI::App* app : {&program, app_}) app->allow_config_extras(CLI::config_extras_mode::error);
  app_->fallthrough();
  return unshielded(program.set_config(names, "", description));
}

Command Command::add_subcommand(const std::string& name, const std::string& description) const {
  return Command(app_->add_subcommand(name, description));
}
void Command::require_subcommand(std::size_t least, std::size_t most) const {
  app_->require_subcommand(least, most);
}
void Command::callback(const std::function<void()>& run) const { app_->callback(run); }
void Command::footer(const std::string& text) const { app_->footer(text); }
void Command::help_all_flag(const std::string& names, const std::string& description) const {
  app_->set_help_all_flag(names, description);
}
void Command::essentials(const std::vector<std::string>& names) const {
  if (own_formatter(*app_) == nullptr) {
    app_->formatter(std::make_shared<HelpFormatter>(app_));
    app_->set_help_all_flag("--help-all", "Print all options and exit");
  }
  own_formatter(*app_)->add_essentials(names);
}

std::string Command::name() const { return app_->get_name(); }
std::string Command::help() const { return app_->help(); }
std::string Command::help_all() const { return app_->help("", CLI::AppFormatMode::All); }
std::vector<Option> Command::options() const {
  const std::vector<CLI::Option*> all = app_->get_options();
  return {all.begin(), all.end()};
}
std::vector<Command> Command::subcommands() const {
  return handles_of(app_->get_subcommands(std::function<bool(CLI::App*)>()));
}
bool Command::parsed() const { return app_->parsed(); }
std::size_t Command::count(const std::string& name) const { return app_->count(name); }
std::vector<Command> Command::parsed_subcommands() const {
  return handles_of(app_->get_subcommands());
}

Program::Program(const std::string& description, const std::string& name)
    : owned_(std::make_unique<CLI::App>(description, name)) {
  app_ = owned_.get();
}

Program::~Program() = default;

void Program::add_common_options() {
  const auto formatter = std::make_shared<HelpFormatter>();
  const auto add = [&](const auto& self, CLI::App& to) -> void {
    if (own_formatter(to) == nullptr) {
      to.formatter(formatter);
      // --help shows all options, too.
      if (to.get_parent() != nullptr)
        to.set_help_all_flag("--help-all", "Print all options and exit")->group("");
    }
    to.set_help_flag("-h,--help", "Print this help and exit");
    to.set_version_flag("--version", name() + " " POINTREEL_VERSION, "Print the version and exit");
    for (CLI::App* command : to.get_subcommands({})) self(self, *command);
  };
  const auto write = [this](const std::string& folder) {
    std::vector<CommandEntry> commands;
    add_entries(commands, *app_, {});
    const auto written = write_manuals(commands, folder);
    if (!written) print_error(name(), written.error().message);
    throw CLI::RuntimeError(written ? 0 : 1);  // there is nothing more to do
  };
  add_option_function<std::string>(
      "--write-manuals", write,
      "Write manual pages, and completions for bash, zsh and fish, to where they are looked for "
      "below FOLDER, such as ~/.local/share, and exit")
      .type_name("FOLDER");
  add(add, *app_);
}

namespace {

/// What is wrong with a command line, in one line.
std::string fault_of(const CLI::App& app, const CLI::Error& error) {
  std::string what = error.what();
  std::erase(what, kShield);
  // It looks for a command before it says that a word is none.
  if (what != "A subcommand is required") return what;
  const std::vector<std::string> others = app.remaining(true);
  if (others.empty()) return "a command is missing";
  return fmt::format("there is no {} \"{}\"", others[0].starts_with('-') ? "option" : "command",
                     others[0].substr(others[0].starts_with(kShield) ? 1 : 0));
}

}  // namespace

Result<void> Program::parse(const std::vector<std::string>& arguments) try {
  app_->parse(last_first(arguments));
  return {};
} catch (const CLI::Error& error) {
  return fail(ErrorCode::argument, fault_of(*app_, error));
}

std::optional<int> Program::parse(int argc, const char* const* argv) {
  // A file that exceeds a limit of the system (ulimit -f) is then reported like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    app_->parse(last_first({argv + std::min(argc, 1), argv + argc}));
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0 || error.get_name() == "RuntimeError") return app_->exit(error);
    std::string command = name();
    for (const CLI::App* given = app_; !given->get_subcommands().empty();) {
      given = given->get_subcommands().front();
      command += " " + given->get_name();
    }
    print_error(name(), fmt::format("{}; see {} --help", fault_of(*app_, error), command));
    return 2;
  } catch (const std::exception& error) {  // from a subcommand; most likely out of memory
    print_error(name(), error.what());
    return 1;
  }
}

}  // namespace pointreel::cli
