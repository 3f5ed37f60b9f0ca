#include "common/command_line/manual.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace roadbalance {
namespace {

/// Commands of a command, in the order of --help.
std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); });
}

/// The options it takes with dashes and without, in the order of --help; no hidden ones.
std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
  return command.get_options([positional](const CLI::Option* one) {
    return !one->get_group().empty() && one->get_positional() == positional;
  });
}

/// True of a command that is a program of its own, which has its own pages and completion (list_program).
bool is_program(const CLI::App& command) {
  return command.get_prefix_command();
}

/// True if a word follows it.
bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

/// Words that begin a command's line: "rb calibrate filter".
std::string command_path(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent ? command_path(*parent) + " " : "") + command.get_name();
}

/// Name of a command's page: "rb-calibrate-filter" for `rb calibrate filter`.
std::string page_name(const CLI::App& command) {
  std::string name = command_path(command);
  std::ranges::replace(name, ' ', '-');
  return name;
}

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

/// "FLOAT", or a name that describes it better than "TEXT".
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
  if (!commands_of(command).empty())
    made +=
        command.get_require_subcommand_min() > 0 ? " " + italic("command") : " [" + italic("command") + "]";
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
  std::string made = ".SH COMMANDS\n", group = CLI::App().get_group();  // that of commands without one
  for (const CLI::App* one : commands) {
    if (one->get_group() != group) made += ".SS " + plain(group = one->get_group()) + "\n";
    made += ".TP\n" + bold(page_name(*one)) + "(1)\n" + plain(one->get_description()) + "\n";
  }
  return made;
}

/// Paragraphs of the footer of --help: "Exit codes: ..." has a section of its own by custom.
std::string footer_sections(const std::string& footer) {
  if (footer.empty()) return "";
  const std::string codes = "Exit codes: ";
  const std::size_t end = std::min(footer.find("\n\n"), footer.size());
  const std::string paragraph = footer.substr(0, end), rest = footer.substr(std::min(end + 2, footer.size()));
  const std::string made = paragraph.starts_with(codes)
                               ? ".SH EXIT STATUS\n" + plain(paragraph.substr(codes.size()))
                               : ".SH NOTES\n" + plain(paragraph);
  return made + "\n" + footer_sections(rest);
}

/// Manual page of one command for man(1), in the macros of man(7): name, synopsis, arguments, options,
/// commands, exit status, what belongs to it.
std::string manual_page(const CLI::App& command) {
  const std::string name = page_name(command);
  std::string made = ".TH \"" + upper(plain(name)) + "\" 1 \"\" roadbalance \"User Commands\"\n";
  made += ".SH NAME\n" + plain(name) + " \\- " + plain(command.get_description()) + "\n";
  made += ".SH SYNOPSIS\n" + synopsis(command) + "\n";
  made += options_section(command, true) + options_section(command, false);
  made += commands_section(command) + footer_sections(command.get_footer());
  if (const CLI::App* parent = command.get_parent())
    made += ".SH SEE ALSO\n" + bold(page_name(*parent)) + "(1)\n";
  return made;
}

std::string join(const std::vector<std::string>& words) {
  std::string made;
  for (const std::string& word : words) made += (made.empty() ? "" : " ") + word;
  return made;
}

/// Its options with all their names.
std::vector<std::string> option_words(const CLI::App& command, bool with_value_only) {
  std::vector<std::string> words;
  for (const CLI::Option* option : options_of(command, false)) {
    if (with_value_only && !takes_value(*option)) continue;
    for (const std::string& name : option->get_snames()) words.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
  return words;
}

/// A line for each option that takes one of some words: the option and these, as its check lists them.
std::string choices_of(const CLI::App& command) {
  std::string lines;
  for (const CLI::Option* option : options_of(command, false)) {
    const std::string type = option->get_type_name();
    const std::size_t begin = type.find('{'), end = type.find('}', begin);
    if (begin == std::string::npos || end == std::string::npos) continue;
    std::vector<std::string> words;
    for (std::size_t at = begin + 1; at < end;) {
      const std::size_t comma = std::min(type.find(',', at), end);
      words.push_back(type.substr(at, std::min(type.find("->", at), comma) - at));
      at = comma + 1;
    }
    for (const std::string& name : option->get_lnames()) lines += "--" + name + " " + join(words) + "\n";
  }
  return lines;
}

/// One branch of the script's `case` for a command and each of its own.
std::string branches(const CLI::App& command) {
  if (is_program(command))
    return "    '" + command_path(command) + "') program=" + page_name(command) + " ;;\n";
  std::vector<std::string> names;
  for (const CLI::App* one : commands_of(command)) names.push_back(one->get_name());
  std::string made = "    '" + command_path(command) + "')\n      commands='" + join(names) +
                     "'\n      options='" + join(option_words(command, false)) + "'\n      valued='" +
                     join(option_words(command, true)) + "'\n      choices='" + choices_of(command) +
                     "' ;;\n";
  for (const CLI::App* one : commands_of(command)) made += branches(*one);
  return made;
}

/// Completion of a program's command line for bash, to be sourced or put into its completions folder:
/// commands, options once a dash is typed, files for whatever else.  The words of a program that is called as
/// a command are left to the completion of that program.
std::string bash_completion(const CLI::App& program) {
  const std::string name = program.get_name();
  std::string function = "_" + name;
  for (char& c : function)
    if (c == '-') c = '_';
  return "# bash completion of " + name + "\n" + function + "_words() {\n  case $1 in\n" + branches(program) +
         "    *) return 1 ;;\n  esac\n}\n" + function + R"(() {
  local commands options valued choices program path=)" +
         name + R"( word before option words of i
  COMPREPLY=()
  )" + function +
         R"(_words "$path"
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ " $valued " == *" $word "* ]]; then ((++i)); continue; fi
    if [[ " $commands " == *" $word "* ]]; then path+=" $word"; )" +
         function + R"(_words "$path"; fi
    if [[ -n $program ]]; then
      COMP_WORDS=("$program" "${COMP_WORDS[@]:i+1}")
      ((COMP_CWORD -= i))
      word=_${program//-/_}
      declare -F "$word" >/dev/null || ! declare -F _completion_loader >/dev/null || _completion_loader "$program"
      if declare -F "$word" >/dev/null; then "$word"; fi
      return
    fi
  done
  word=${COMP_WORDS[COMP_CWORD]}
  before=${COMP_WORDS[COMP_CWORD - 1]}
  while read -r option words; do [[ $option == "$before" ]] && of=$words; done <<<"$choices"
  if [[ -n $of ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$of" -- "$word")
  elif [[ " $valued " == *" $before "* ]]; then
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
  elif [[ -n $commands ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -o filenames -F )" +
         function + " " + name + "\n";
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text << std::flush))
    throw CLI::FileError("cannot write " + path.string() + ": " + std::generic_category().message(errno));
}

void write_pages(const CLI::App& command, const std::filesystem::path& folder) {
  write_file(folder / (page_name(command) + ".1"), manual_page(command));
  for (const CLI::App* one : commands_of(command))
    if (!is_program(*one)) write_pages(*one, folder);
}

}  // namespace

void add_manual(CLI::App& app) {
  const auto write = [&app](const std::string& name) {
    const std::filesystem::path folder(name);
    std::error_code trouble;
    std::filesystem::create_directories(folder, trouble);  // what is in the way shows when a file is written
    write_pages(app, folder);
    write_file(folder / (app.get_name() + ".bash"), bash_completion(app));
    throw CLI::Success();
  };
  app.add_option_function<std::string>("--write-manual", write)->trigger_on_parse()->group("");
}

}  // namespace roadbalance
