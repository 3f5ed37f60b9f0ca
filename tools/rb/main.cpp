#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "common/config/section.hpp"
#include "tools/rb/command.hpp"

namespace {

/// CLI11 alone would only say that a subcommand is required.
void refuse_unknown_subcommand(CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const auto all = app.get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* command : all)
    if (command->get_name() == argv[1]) return;
  throw roadbalance::ConfigError(std::string("unknown subcommand ") + argv[1] + "; rb --help lists them");
}

int fail(const std::exception& error, int code) {
  std::fprintf(stderr, "rb: %s\n", error.what());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app("roadbalance: balances wheels on the moving car.", "rb");
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 the answer is no, 2 usage or configuration, 3 incomplete but every gap "
      "declared, "
      "4 cannot read or write.");
  int code = kDone;
  add_demo(app, code);
  add_watch(app, code);
  add_doctor(app, code);
  add_identify(app, code);
  add_verify(app, code);
  add_levels(app, code);
  add_spectrum(app, code);
  add_study(app, code);
  add_import(app, code);
  try {
    refuse_unknown_subcommand(app, argc, argv);
    app.parse(argc, argv);
    return code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  } catch (const ConfigError& error) {
    return fail(error, kUsage);
  } catch (const std::exception& error) {
    return fail(error, kCannotAccess);
  }
}
