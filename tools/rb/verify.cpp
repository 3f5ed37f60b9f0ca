#include "host/recorder/verify.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/rb/command.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct VerifyOptions {
  std::string folder;
  bool json = false;
};

const char* cause_name(GapCause cause) {
  switch (cause) {
    case GapCause::kRingFull:
      return "ring_full";
    case GapCause::kDeviceOverrun:
      return "device_overrun";
    case GapCause::kDeviceFailed:
      return "device_failed";
    case GapCause::kLostAtNode:
      return "lost_at_node";
    case GapCause::kNodeCrash:
      return "node_crash";
    case GapCause::kSourceGap:
      return "source_gap";
  }
  return "unknown";
}

Json spans(const std::vector<MissingSpan>& missing) {
  Json list = Json::array();
  for (const auto& span : missing) list.push_back({{"first", span.first}, {"last", span.last}});
  return list;
}

Json epoch_json(const VerifiedEpoch& epoch) {
  Json gaps = Json::array();
  for (const auto& gap : epoch.gaps)
    gaps.push_back({{"cause", cause_name(gap.cause)}, {"first_scan", gap.first_scan}, {"scans", gap.scans}});
  return {{"node", epoch.node},
          {"epoch", epoch.epoch},
          {"complete", epoch.is_complete()},
          {"ended", epoch.ended},
          {"blocks", epoch.blocks},
          {"samples_sent", epoch.samples_sent},
          {"samples_recorded", epoch.samples},
          {"samples_missing", epoch.samples_missing},
          {"gaps", gaps},
          {"undeclared_blocks", spans(epoch.undeclared_blocks)},
          {"undeclared_scans", spans(epoch.undeclared_scans)},
          {"repeated_blocks", epoch.repeated_blocks},
          {"overlapping_blocks", epoch.overlapping_blocks},
          {"contradictions", epoch.contradictions}};
}

Json verification_json(const Verification& result) {
  Json nodes = Json::array();
  for (const auto& epoch : result.epoch) nodes.push_back(epoch_json(epoch));
  return {{"complete", result.verdict == Verdict::kComplete},
          {"verdict", verdict_text(result)},
          {"missing_segments", result.missing_segments},
          {"nodes", nodes},
          {"events", result.events},
          {"blocks_refused", result.blocks_refused},
          {"damaged_bytes", result.damaged_bytes},
          {"torn_bytes", result.torn_bytes},
          {"damage", result.damage}};
}

void print(const Verification& result) {
  for (const auto& epoch : result.epoch) {
    std::printf("node %d epoch %lld: %lld blocks, %lld samples of %lld, %zu gaps, %s%s\n", epoch.node,
                static_cast<long long>(epoch.epoch), static_cast<long long>(epoch.blocks),
                static_cast<long long>(epoch.samples), static_cast<long long>(epoch.samples_sent),
                epoch.gaps.size(),
                epoch.is_damaged()    ? "damaged"
                : epoch.is_complete() ? "complete"
                                      : "incomplete",
                epoch.ended ? "" : ", no end");
    for (const auto& gap : epoch.gaps)
      std::printf("  gap from scan %lld, %lld scans: %s\n", static_cast<long long>(gap.first_scan),
                  static_cast<long long>(gap.scans), cause_name(gap.cause));
    for (const auto& span : epoch.undeclared_blocks)
      std::printf("  blocks %lld to %lld are missing, undeclared\n", static_cast<long long>(span.first),
                  static_cast<long long>(span.last));
    for (const auto& contradiction : epoch.contradictions) std::printf("  %s\n", contradiction.c_str());
  }
  for (const auto& line : result.damage) std::printf("%s\n", line.c_str());
  std::printf("%s\n", verdict_text(result).c_str());
}

int verify(const VerifyOptions& options) {
  const Verification result = verify_record(options.folder);
  if (result.verdict == Verdict::kUnreadable) throw std::runtime_error(result.error);
  if (options.json)
    std::printf("%s\n", verification_json(result).dump().c_str());
  else
    print(result);
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
