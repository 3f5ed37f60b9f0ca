#include "common/command_line/completion.hpp"

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

/// One branch of the script's `case` for a command and each of its own.
std::string branches(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* one : commands_of(command)) names.push_back(one->get_name());
  std::string made = "    '" + command_path(command) + "')\n      commands='" + join(names) +
                     "'\n      options='" + join(option_words(command, false)) + "'\n      valued='" +
                     join(option_words(command, true)) + "' ;;\n";
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
  local commands options valued path=)" +
         name + R"( word i
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
  if [[ " $valued " == *" ${COMP_WORDS[COMP_CWORD - 1]} "* ]]; then
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
