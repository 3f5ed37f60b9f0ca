// Studies over many seeds, and recorded drives put to research estimators: rb study NAME, rb identify
// --estimator NAME
#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "common/command_line/exit_code.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "tools/study/identify_with.hpp"
#include "tools/study/study_command.hpp"

int main(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app(kStudySentence, "rb-study");
  int code = kDone;
  add_study(app, code, run_campaign, static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
            true);
  add_identify_with(app, code);
  app.footer("Exit codes: 0 done, 1 the answer is no, 2 usage or configuration, 4 cannot read or write.");
  add_version(app);
  add_manual(app);
  return run_program(app, {argv + 1, argv + argc}, code);
}
