#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <span>
#include <string>

#include "common/command_line/manual.hpp"
#include "common/config/section.hpp"
#include "common/record/failure_words.hpp"
#include "tools/rb/command.hpp"

namespace {

/// CLI11 alone would only say that a subcommand is required.
void refuse_unknown_subcommand(const CLI::App& app, std::span<char*> words, const std::string& path) {
  const auto all = app.get_subcommands([](const CLI::App*) { return true; });
  if (all.empty() || words.empty() || words[0][0] == '-') return;
  for (const CLI::App* command : all)
    if (command->get_name() == words[0])
      return refuse_unknown_subcommand(*command, words.subspan(1), path + " " + words[0]);
  throw roadbalance::ConfigError(std::string("unknown subcommand ") + words[0] + "; " + path +
                                 " --help lists them");
}

/// A result that did not reach its reader, of a full disk for one, is no success.
int written(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fprintf(stderr, "rb: cannot write the result\n");
  return roadbalance::kCannotAccess;
}

/// CLI11 alone would not say which program and command does not take it.
std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  std::string path = app->get_name();
  for (auto chosen = app->get_subcommands(); !chosen.empty(); chosen = chosen.front()->get_subcommands())
    path += " " + chosen.front()->get_name();
  return path + ": " + error.what() + "; " + path + " --help says more\n";
}

int fail(const std::exception& error, int code) {
  std::fprintf(stderr, "rb: %s\n", roadbalance::failure_words(error).c_str());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app("roadbalance: balances wheels on the moving car.", "rb");
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 the answer is no, 2 usage or configuration, 3 incomplete but every gap "
      "declared, 4 cannot read or write.\n"
      "Errors are said on standard error; then --json prints nothing.");
  app.failure_message(usage_error);
  int code = kDone;
  add_demo(app, code);
  add_watch(app, code);
  add_start(app, code);
  add_stop(app, code);
  add_mark(app, code);
  add_configure(app, code);
  add_zero(app, code);
  add_vehicle(app, code);
  add_datum(app, code);
  add_calibrate(app, code);
  add_wiring(app, code);
  add_doctor(app, code);
  add_identify(app, code);
  add_distance(app, code);
  add_verify(app, code);
  add_recover(app, code);
  add_info(app, code);
  add_report(app, code);
  add_levels(app, code);
  add_orders(app, code);
  add_twin(app, code);
  add_balance(app, code);
  add_spectrum(app, code);
  add_response(app, code);
  add_model(app, code);
  add_study(app, code);
  add_replay(app, code);
  add_select(app, code);
  add_reduce(app, code);
  add_transfer(app, code);
  add_import(app, code);
  add_export(app, code);
  add_supervise(app, code);
  add_manual(app);
  try {
    refuse_unknown_subcommand(app, std::span(argv, static_cast<std::size_t>(argc)).subspan(1), "rb");
    app.parse(argc, argv);
    return written(code);
  } catch (const CLI::ParseError& error) {
    return written(app.exit(error) == 0 ? kDone : kUsage);
  } catch (const ConfigError& error) {
    return fail(error, kUsage);
  } catch (const std::exception& error) {
    return fail(error, kCannotAccess);
  }
}
