#include "common/command_line/manual_page.hpp"

#include <algorithm>
#include <cctype>

#include "common/command_line/commands.hpp"

namespace roadbalance {
namespace {

/// Text as roff takes it for itself: no request at a line's begin, dashes that can be copied, no escapes.
std::string plain(const std::string& text) {
  std::string made;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) made += "\\&";
    if (c == '-')
      made += "\\-";
    else if (c == '\\')
      made += "\\e";
    else if (c == '"')
      made += "\\(dq";
    else
      made += c;
    line_begins = c == '\n';
  }
  return made;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string bold(const std::string& text) {
  return "\\fB" + plain(text) + "\\fR";
}
std::string italic(const std::string& text) {
  return "\\fI" + plain(text) + "\\fR";
}

/// "FLOAT", or what a name says better than "TEXT".
std::string value_name(const CLI::Option& option) {
  if (option.get_positional()) return option.get_name(true);
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

std::string many(const CLI::Option& option) {
  return option.get_expected_max() > 1 ? " ..." : "";
}

std::string with_value(const std::string& name, const CLI::Option& option) {
  return takes_value(option) ? name + " " + italic(value_name(option)) + many(option) : name;
}

/// "\fB-o\fR, \fB--output\fR \fITEXT\fR"
std::string names(const CLI::Option& option) {
  std::string made;
  const auto add = [&made](const std::string& name) { made += (made.empty() ? "" : ", ") + bold(name); };
  for (const std::string& name : option.get_snames()) add("-" + name);
  for (const std::string& name : option.get_lnames()) add("--" + name);
  return with_value(made, option);
}

std::string synopsis(const CLI::App& command) {
  std::string made = bold(command_path(command));
  bool optional = false;
  for (const CLI::Option* option : options_of(command, false)) {
    if (option->get_required())
      made += " " + with_value(bold(option->get_name()), *option);
    else
      optional = true;
  }
  if (optional) made += " [" + italic("options") + "]";
  for (const CLI::Option* option : options_of(command, true)) {
    const std::string name = italic(value_name(*option)) + many(*option);
    made += option->get_required() ? " " + name : " [" + name + "]";
  }
  if (!commands_of(command).empty()) made += " " + italic("command");
  return made;
}

std::string explained(const CLI::Option& option) {
  std::string made = option.get_description();
  if (!option.get_default_str().empty()) made += "; default: " + option.get_default_str();
  return plain(made);
}

std::string options_section(const CLI::App& command, bool positional) {
  const auto options = options_of(command, positional);
  if (options.empty()) return "";
  std::string made = positional ? ".SH ARGUMENTS\n" : ".SH OPTIONS\n";
  for (const CLI::Option* option : options)
    made += ".TP\n" + (positional ? italic(value_name(*option)) + many(*option) : names(*option)) + "\n" +
            explained(*option) + "\n";
  return made;
}

std::string commands_section(const CLI::App& command) {
  const auto commands = commands_of(command);
  if (commands.empty()) return "";
  std::string made = ".SH COMMANDS\n";
  for (const CLI::App* one : commands)
    made += ".TP\n" + bold(page_name(*one)) + "(1)\n" + plain(one->get_description()) + "\n";
  return made;
}

/// The footer of --help: "Exit codes: ..." has a section of its own by custom.
std::string exit_section(const CLI::App& command) {
  const std::string footer = command.get_footer(), codes = "Exit codes: ";
  if (footer.empty()) return "";
  if (!footer.starts_with(codes)) return ".SH NOTES\n" + plain(footer) + "\n";
  return ".SH EXIT STATUS\n" + plain(footer.substr(codes.size())) + "\n";
}

}  // namespace

std::string command_path(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent ? command_path(*parent) + " " : "") + command.get_name();
}

std::string page_name(const CLI::App& command) {
  std::string name = command_path(command);
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string manual_page(const CLI::App& command) {
  const std::string name = page_name(command);
  std::string made = ".TH \"" + upper(plain(name)) + "\" 1 \"\" roadbalance \"User Commands\"\n";
  made += ".SH NAME\n" + plain(name) + " \\- " + plain(command.get_description()) + "\n";
  made += ".SH SYNOPSIS\n" + synopsis(command) + "\n";
  made += options_section(command, true) + options_section(command, false);
  made += commands_section(command) + exit_section(command);
  if (const CLI::App* parent = command.get_parent())
    made += ".SH SEE ALSO\n" + bold(page_name(*parent)) + "(1)\n";
  return made;
}

}  // namespace roadbalance
