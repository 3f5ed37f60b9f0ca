#include "common/command_line/run_program.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>

#include "common/command_line/exit_code.hpp"
#include "common/config/section.hpp"
#include "common/record/failure_words.hpp"
#include "common/text/printable.hpp"

namespace roadbalance {
namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

/// CLI11 alone would only report that a subcommand is required.
void refuse_unknown_command(CLI::App& app, const std::vector<std::string>& words) {
  CLI::App* command = &app;
  std::string path = app.get_name();
  for (const std::string& word : words) {
    if (command->get_require_subcommand_min() == 0 || word.starts_with('-')) return;
    command = &command_named(*command, {word}, path);
    path += " " + word;
  }
}

/// CLI11 alone would not name the program and command that does not take it.
std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  std::string path = app->get_name();
  for (auto chosen = app->get_subcommands(); !chosen.empty(); chosen = chosen.front()->get_subcommands())
    path += " " + chosen.front()->get_name();
  return path + ": " + printable_text(error.what()) + "; " + path + " --help says more\n";
}

/// A result that did not reach its reader, of a full disk for one, is no success.
int written(const CLI::App& app, int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fprintf(stderr, "%s: cannot write the result\n", app.get_name().c_str());
  return kCannotAccess;
}

int fail(const CLI::App& app, const std::exception& error, int code) {
  report(app.get_name(), failure_words(error));
  return code;
}

}  // namespace

void add_version(CLI::App& app) {
  app.set_version_flag("--version", app.get_name() + " " RB_VERSION, "print the version and exit");
}

CLI::App* list_program(CLI::App& app, const std::string& name, const std::string& description) {
  return app.add_subcommand(name, description)->prefix_command();
}

CLI::App& command_named(CLI::App& app, const std::vector<std::string>& words, const std::string& path) {
  if (words.empty()) return app;
  const std::string& word = words.front();
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (command->get_name() == word)
      return command_named(*command, {words.begin() + 1, words.end()}, path + " " + word);
  throw ConfigError("unknown subcommand " + word + did_you_mean(word, command_names(app)) + "; " + path +
                    " --help lists them");
}

void report(const std::string& program, const std::string& sentence) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), printable_text(sentence).c_str());
}

int report_failure(CLI::App& app, const std::exception& error) {
  if (const auto* of_line = dynamic_cast<const CLI::ParseError*>(&error)) {
    app.failure_message(usage_error);
    return app.exit(*of_line) == 0 ? kDone : kUsage;
  }
  report(app.get_name(), error.what());
  return dynamic_cast<const ConfigError*>(&error) != nullptr ? kUsage : kCannotAccess;
}

int run_program(CLI::App& app, std::vector<std::string> words, const int& code) {
  app.failure_message(usage_error);
  try {
    refuse_unknown_command(app, words);
    std::ranges::reverse(words);  // as CLI11 takes them
    app.parse(words);
    return written(app, code);
  } catch (const CLI::ParseError& error) {
    return written(app, app.exit(error) == 0 ? kDone : kUsage);
  } catch (const ConfigError& error) {
    return fail(app, error, kUsage);
  } catch (const std::exception& error) {
    return fail(app, error, kCannotAccess);
  }
}

}  // namespace roadbalance
