#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/record/failure_words.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/other_program.hpp"

namespace {

using namespace roadbalance;

/// The commands by what a person wants, as --help lists them.
struct Group {
  const char* name;
  std::vector<void (*)(CLI::App& app, int& code)> commands;
};
const std::vector<Group> kGroups{
    {"See the car", {add_demo, add_watch}},
    {"Record", {add_start, add_stop, add_mark, add_supervise}},
    {"Judge", {add_verify, add_identify, add_balance, add_report}},
    {"Look", {add_info, add_levels, add_spectrum, add_response, add_orders, add_twin, add_replay}},
    {"Exchange", {add_import, add_export, add_select, add_reduce, add_transfer, add_recover}},
    {"Set up",
     {add_doctor, add_vehicle, add_configure, add_zero, add_datum, add_calibrate, add_wiring, add_distance}},
    {"Develop",
     {add_model,
      [](CLI::App& app, int&) {
        list_program(app, "study", "Repeats an experiment over many seeds and prints what came out");
        list_program(app, "mpi", "Studies, and identification from many recordings, over a cluster");
      }}},
};

void add_commands(CLI::App& app, int& code) {
  const std::string none = app.get_group();  // as it is of commands without one
  for (const Group& group : kGroups) {
    for (const auto add : group.commands) add(app, code);
    for (CLI::App* command :
         app.get_subcommands([&](const CLI::App* one) { return one->get_group() == none; }))
      command->group(group.name);
  }
  app.add_subcommand("help", "Prints the help of a command: rb help COMMAND")->group("");
}

/// Without any, `rb` prints its help; `rb help NAME` is `rb NAME --help`.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool asks =
      words.empty() || (words.front() == "help" && !(words.size() > 1 && words[1].starts_with('-')));
  if (!asks) return words;
  if (!words.empty()) words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

/// As git and cargo run theirs: what rb does not do itself.
bool is_other_program(const CLI::App& app, const std::string& word) {
  if (word.starts_with('-')) return false;
  const auto own = app.get_subcommands([&](const CLI::App* one) { return one->get_name() == word; });
  return own.empty() ? program_of_command(word).has_value() : own.front()->get_prefix_command();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("roadbalance: balances wheels on the moving car.", "rb");
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 the answer is no, 2 usage or configuration, 3 incomplete but every gap "
      "declared, 4 cannot read or write.\n"
      "Errors are printed on standard error; then --json prints nothing.\n\n"
      "rb help COMMAND prints the help of one.  rb NAME runs the program rb-NAME, beside rb or in a folder "
      "of "
      "PATH, where rb has no such command itself.");
  int code = kDone;
  add_commands(app, code);
  add_version(app);
  add_manual(app);
  const std::vector<std::string> words = words_of(argc, argv);
  try {
    if (is_other_program(app, words.front())) become_program(words.front(), {words.begin() + 1, words.end()});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb: %s\n", failure_words(error).c_str());
    return kCannotAccess;
  }
  return run_program(app, words, code);
}
