#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/record/part.hpp"
#include "common/record/record_folder.hpp"
#include "host/recording/recover/recover.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

struct RecoverOptions {
  std::string folder;
  std::string target;
  std::vector<std::string> spools;
  bool json = false;
};

/// Only what can be read is there to be recovered, and it stays as it is: nothing may be written into it.
void refuse_sources(const std::vector<fs::path>& sources, const fs::path& target) {
  for (const fs::path& source : sources) {
    if (!fs::exists(source)) throw std::runtime_error(source.string() + ": no such folder");
    if (!fs::is_directory(source)) throw std::runtime_error(source.string() + ": is no folder");
  }
  expect_beside(sources, target);
}

/// A record that grows while it is read is none that can be recovered.
std::vector<File> hold_all(const std::vector<fs::path>& sources) {
  std::vector<File> held;
  for (const fs::path& source : sources)
    if (std::ranges::none_of(held, [&](const File& other) { return other.is_at(source); }))
      held.push_back(hold_at_rest(source, "recover it"));
  return held;
}

/// The new record appears with all it is to hold, or not at all.
Recovered recover_whole(const std::vector<fs::path>& sources, const fs::path& target) {
  refuse_sources(sources, target);
  const std::vector<File> held = hold_all(sources);
  Part folder(target, Part::Kind::kFolder);
  const Recovered recovered = recover(sources, folder.part());
  folder.keep();
  return recovered;
}

void print(const RecoverOptions& options, const Recovered& recovered, const Verification& result) {
  if (options.json) {
    const nlohmann::ordered_json json = {{"blocks", recovered.blocks},
                                         {"gaps", recovered.gaps},
                                         {"blocks_filled", recovered.blocks_filled},
                                         {"blocks_repeated", recovered.blocks_repeated},
                                         {"blocks_altered", recovered.blocks_altered},
                                         {"entries_altered", recovered.entries_altered},
                                         {"headers_altered", recovered.headers_altered},
                                         {"missing_segments", recovered.missing_segments},
                                         {"damaged_bytes", recovered.damaged_bytes},
                                         {"damage", recovered.damage},
                                         {"lost", recovered.lost},
                                         {"record", verification_json(result)}};
    std::printf("%s\n", json.dump().c_str());
    return;
  }
  for (const auto& line : recovered.damage) std::printf("%s\n", line.c_str());
  std::printf(
      "%lld blocks recovered, %lld of them to fill holes; %lld gaps declared\n"
      "found: %lld blocks more than once, %lld altered; %lld other entries altered; %llu bytes damaged; %lld "
      "segments missing or not as they were finished\n",
      static_cast<long long>(recovered.blocks), static_cast<long long>(recovered.blocks_filled),
      static_cast<long long>(recovered.gaps), static_cast<long long>(recovered.blocks_repeated),
      static_cast<long long>(recovered.blocks_altered), static_cast<long long>(recovered.entries_altered),
      static_cast<unsigned long long>(recovered.damaged_bytes),
      static_cast<long long>(recovered.missing_segments));
  if (!recovered.lost.empty())
    std::printf("whether a mark or a whole node epoch was in what is lost, nothing can tell\n");
  print_verification(result);
}

int recover(const RecoverOptions& options) {
  std::vector<fs::path> sources{options.folder};
  sources.insert(sources.end(), options.spools.begin(), options.spools.end());
  try {
    const Recovered recovered = recover_whole(sources, options.target);
    const Verification result = verify_record(options.target);
    print(options, recovered, result);
    if (result.verdict == Verdict::kComplete) return kDone;
    return result.verdict == Verdict::kDamaged || result.verdict == Verdict::kUnreadable ? kAnswerIsNo
                                                                                         : kIncomplete;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb recover: cannot recover %s: %s\n", options.folder.c_str(), error.what());
    return kAnswerIsNo;
  }
}

}  // namespace

void add_recover(CLI::App& app, int& code) {
  auto options = std::make_shared<RecoverOptions>();
  CLI::App* command = app.add_subcommand(
      "recover", "Makes a good recording of all that is good in a damaged one, which stays as it is");
  command->add_option("folder", options->folder, "the damaged recording")->required();
  command->add_option("-o,--output", options->target, "the new recording: a new or empty folder")->required();
  command->add_option("--spool", options->spools,
                      "a spool that a node left, or a fallback recording: its blocks fill what is missing");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->footer(
      "Exit codes: 0 nothing is lost, 3 something is, or may be in what is damaged, missing or in a folder "
      "that is not named, and is listed, 1 could not.");
  command->callback([options, &code] { code = recover(*options); });
}

}  // namespace roadbalance
