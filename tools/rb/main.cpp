#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "common/config/section.hpp"
#include "tools/rb/command.hpp"

namespace {

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
  add_spectrum(app, code);
  add_study(app, code);
  add_import(app, code);
  try {
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
