#include "host/recording/verify/verify.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "tools/rb/command.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

struct VerifyOptions {
  std::string folder;
  bool json = false;
};

int verify(const VerifyOptions& options) {
  const Verification result = [&] {
    const ReadingProgress progress(options.folder, 1);
    return verify_record(options.folder);
  }();
  if (result.verdict == Verdict::kUnreadable) throw std::runtime_error(result.error);
  if (options.json)
    std::printf("%s\n", verification_json(result).dump().c_str());
  else
    print_verification(result);
  return static_cast<int>(result.verdict);
}

}  // namespace

void add_verify(CLI::App& app, int& code) {
  auto options = std::make_shared<VerifyOptions>();
  CLI::App* command = app.add_subcommand("verify", "Proves a recording complete, or lists what is not there");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = verify(*options); });
}

}  // namespace roadbalance
