#include "common/command_line/completion.hpp"

#include <algorithm>

#include "common/command_line/commands.hpp"
#include "common/command_line/manual_page.hpp"

namespace roadbalance {
namespace {

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
  std::vector<std::string> names;
  for (const CLI::App* one : commands_of(command)) names.push_back(one->get_name());
  std::string made = "    '" + command_path(command) + "')\n      commands='" + join(names) +
                     "'\n      options='" + join(option_words(command, false)) + "'\n      valued='" +
                     join(option_words(command, true)) + "'\n      choices='" + choices_of(command) +
                     "' ;;\n";
  for (const CLI::App* one : commands_of(command)) made += branches(*one);
  return made;
}

}  // namespace

std::string bash_completion(const CLI::App& program) {
  const std::string name = program.get_name();
  std::string function = "_" + name;
  for (char& c : function)
    if (c == '-') c = '_';
  return "# bash completion of " + name + "\n" + function + "_words() {\n  case $1 in\n" + branches(program) +
         "    *) return 1 ;;\n  esac\n}\n" + function + R"(() {
  local commands options valued choices path=)" +
         name + R"( word before option words of i
  COMPREPLY=()
  )" + function +
         R"(_words "$path"
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ " $valued " == *" $word "* ]]; then ((++i)); continue; fi
    if [[ " $commands " == *" $word "* ]]; then path+=" $word"; )" +
         function + R"(_words "$path"; fi
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

}  // namespace roadbalance
