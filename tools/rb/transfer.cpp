#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/process/stop_on_signal.hpp"
#include "host/recording/transfer/transfer.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/progress_line.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct TransferOptions {
  std::vector<std::string> folders;
  std::string to;
  bool json = false;
};

Json report_json(const std::string& from, const TransferReport& report) {
  Json files = Json::array();
  for (const TransferredFile& file : report.file)
    files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", hexadecimal(file.digest)}});
  return {{"from", from},
          {"to", report.to.string()},
          {"bytes", report.bytes},
          {"resumed_bytes", report.resumed_bytes},
          {"was_there", report.was_there},
          {"files", files}};
}

int run_transfer(const TransferOptions& options) {
  const StopOnSignal signals;
  Json all = Json::array();
  for (const std::string& folder : options.folders) {
    const TransferReport report = [&] {
      ProgressLine line;
      return transfer(folder, options.to, signals.token(), [&](std::uint64_t done, std::uint64_t of) {
        line.show(of > 0 ? static_cast<double>(done) / static_cast<double>(of) : 1.0, done);
      });
    }();
    const double megabytes = 1e-6 * static_cast<double>(report.bytes);
    if (options.json)
      all.push_back(report_json(folder, report));
    else if (report.was_there)
      std::printf("%s: there already, %.1f MB compared and equal\n", report.to.c_str(), megabytes);
    else
      std::printf("%s: %.1f MB in %zu files, read back and equal (%.1f MB were there)\n", report.to.c_str(),
                  megabytes, report.file.size(), 1e-6 * static_cast<double>(report.resumed_bytes));
  }
  if (options.json) std::printf("%s\n", Json{{"transferred", all}}.dump().c_str());
  return kDone;
}

}  // namespace

void add_transfer(CLI::App& app, int& code) {
  auto options = std::make_shared<TransferOptions>();
  CLI::App* command = app.add_subcommand(
      "transfer", "Takes recordings to another disk, proven by digest; interrupted it goes on where it was");
  command->add_option("folders", options->folders, "the recordings; they stay as they are")->required();
  command->add_option("--to", options->to, "folder that is to hold the copies, each under its own name")
      ->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->footer(
      "The copy is NAME.part until all of it has been read back; sha256.txt in it is what sha256sum -c "
      "reads.\nExit codes: 0 the copies are equal, 2 usage, 4 cannot read or write, or another recording has "
      "this name there.");
  command->callback([options, &code] { code = run_transfer(*options); });
}

}  // namespace roadbalance
