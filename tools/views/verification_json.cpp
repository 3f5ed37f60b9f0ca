#include "tools/views/verification_json.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* cause_name(GapCause cause) {
  switch (cause) {
    case GapCause::kRingFull:
      return "ring_full";
    case GapCause::kDeviceOverrun:
      return "device_overrun";
    case GapCause::kLostAtNode:
      return "lost_at_node";
    case GapCause::kNodeCrash:
      return "node_crash";
    case GapCause::kSourceGap:
      return "source_gap";
    case GapCause::kLostInRecord:
      return "lost_in_record";
    case GapCause::kDeviceGone:
      return "device_gone";
    case GapCause::kStartedLate:
      return "started_late";
    case GapCause::kSlept:
      return "slept";
  }
  return "unknown";
}

double milliseconds(std::int64_t scans, const VerifiedEpoch& epoch) {
  return static_cast<double>(scans) * static_cast<double>(epoch.period_ps) * 1e-9;
}

Json spans(const std::vector<MissingSpan>& missing) {
  Json list = Json::array();
  for (const auto& span : missing) list.push_back({{"first", span.first}, {"last", span.last}});
  return list;
}

Json losses_json(const NodeLosses& losses) {
  Json json;
  NodeLosses::list([&json](const char* name, const auto& count) { json[name] = count; }, losses);
  return json;
}

bool was_absent(const VerifiedEpoch& epoch, const Verification& result) {
  return std::ranges::find(result.absent, epoch.node, &Verification::Absent::node) != result.absent.end();
}

Json epoch_json(const VerifiedEpoch& epoch, const Verification& result) {
  Json gaps = Json::array();
  for (const auto& gap : epoch.gaps)
    gaps.push_back({{"cause", cause_name(gap.cause)},
                    {"first_block", gap.first_block},
                    {"last_block", gap.sequence},
                    {"first_scan", gap.first_scan},
                    {"scans", gap.scans},
                    {"scans_known", gap.scans > 0 || gap.has_no_scans},
                    {"milliseconds", milliseconds(gap.scans, epoch)}});
  return {{"node", epoch.node},
          {"epoch", epoch.epoch},
          {"complete", epoch.is_complete() && !was_absent(epoch, result)},
          {"absent", was_absent(epoch, result)},
          {"ended", epoch.ended},
          {"blocks", epoch.blocks},
          {"samples_sent", epoch.samples_sent},
          {"samples_recorded", epoch.samples},
          {"samples_missing", epoch.samples_missing},
          {"samples_deleted", epoch.samples_deleted},
          {"gaps", gaps},
          {"undeclared_blocks", spans(epoch.undeclared_blocks)},
          {"undeclared_scans", spans(epoch.undeclared_scans)},
          {"repeated_blocks", epoch.repeated_blocks},
          {"contradicting_blocks", epoch.contradicting_blocks},
          {"overlapping_blocks", epoch.overlapping_blocks},
          {"contradictions", epoch.contradictions},
          {"losses", losses_json(epoch.losses)}};
}

const char* verdict_of(const VerifiedEpoch& epoch, const Verification& result) {
  if (epoch.is_damaged()) return "damaged";
  if (was_absent(epoch, result)) return "was absent";
  return epoch.is_complete() ? "complete" : "incomplete";
}

std::string blocks_of(const VerifiedGap& gap) {
  if (gap.first_block == gap.sequence) return "block " + std::to_string(gap.sequence);
  return "blocks " + std::to_string(gap.first_block) + " to " + std::to_string(gap.sequence);
}

void print_gap(const VerifiedGap& gap, const VerifiedEpoch& epoch) {
  std::printf("  gap, %s, ", blocks_of(gap).c_str());
  if (gap.scans > 0)
    std::printf("from scan %lld on %lld scans, %.1f ms", static_cast<long long>(gap.first_scan),
                static_cast<long long>(gap.scans), milliseconds(gap.scans, epoch));
  else if (gap.has_no_scans)
    std::printf("no scans: edges, signals or description");
  else
    std::printf("from scan %lld on, how many is not known", static_cast<long long>(gap.first_scan));
  std::printf(": %s\n", cause_name(gap.cause));
}

void print_epoch(const VerifiedEpoch& epoch, const Verification& result) {
  std::printf("node %d epoch %lld: %lld blocks, %lld samples of %lld, %zu gaps, %s%s\n", epoch.node,
              static_cast<long long>(epoch.epoch), static_cast<long long>(epoch.blocks),
              static_cast<long long>(epoch.samples), static_cast<long long>(epoch.samples_sent),
              epoch.gaps.size(), verdict_of(epoch, result), epoch.ended ? "" : ", no end");
  if (epoch.samples_deleted > 0)
    std::printf("  the first %lld scans are not in this folder any more, or never were\n",
                static_cast<long long>(epoch.samples_deleted));
  for (const auto& gap : epoch.gaps) print_gap(gap, epoch);
  for (const auto& span : epoch.undeclared_blocks)
    std::printf("  blocks %lld to %lld are missing, undeclared\n", static_cast<long long>(span.first),
                static_cast<long long>(span.last));
  for (const auto& span : epoch.undeclared_scans)
    std::printf("  scans %lld to %lld, %.1f ms, are missing, undeclared\n",
                static_cast<long long>(span.first), static_cast<long long>(span.last),
                milliseconds(span.last - span.first + 1, epoch));
  if (epoch.overlapping_blocks > 0)
    std::printf("  %lld blocks hold scans that an earlier one holds too\n",
                static_cast<long long>(epoch.overlapping_blocks));
  if (epoch.repeated_blocks > 0)
    std::printf("  %lld blocks are there again, the same\n", static_cast<long long>(epoch.repeated_blocks));
  if (epoch.contradicting_blocks > 0)
    std::printf("  %lld blocks are there again, with another content\n",
                static_cast<long long>(epoch.contradicting_blocks));
  for (const auto& contradiction : epoch.contradictions) std::printf("  %s\n", contradiction.c_str());
}

}  // namespace

nlohmann::ordered_json verification_json(const Verification& result) {
  Json nodes = Json::array();
  for (const auto& epoch : result.epoch) nodes.push_back(epoch_json(epoch, result));
  Json absent = Json::array();
  for (const auto& one : result.absent) absent.push_back({{"node", one.node}, {"text", one.text}});
  return {{"complete", result.verdict == Verdict::kComplete},
          {"verdict", verdict_text(result)},
          {"missing_segments", result.missing_segments},
          {"nodes", nodes},
          {"events", result.events},
          {"blocks_refused", result.blocks_refused},
          {"entries_refused", result.entries_refused},
          {"journal_entries", result.journal_entries},
          {"deleted_segments", result.deleted_segments},
          {"damaged_bytes", result.damaged_bytes},
          {"altered_headers", result.altered_headers},
          {"torn_bytes", result.torn_bytes},
          {"damage", result.damage},
          {"lost", result.lost},
          {"absent", absent},
          {"elsewhere", result.elsewhere},
          {"not_read", result.not_read},
          {"notes", result.notes},
          {"indexes", result.indexes}};
}

void print_verification(const Verification& result) {
  for (const auto& epoch : result.epoch) print_epoch(epoch, result);
  for (const auto& line : result.notes) std::printf("%s\n", line.c_str());
  for (const auto& line : result.damage) std::printf("%s\n", line.c_str());
  for (const auto& line : result.lost) std::printf("%s\n", line.c_str());
  for (const auto& one : result.absent) std::printf("%s\n", one.text.c_str());
  for (const auto& line : result.elsewhere) std::printf("%s\n", line.c_str());
  for (const auto& line : result.not_read) std::printf("%s\n", line.c_str());
  for (const auto& line : result.indexes) std::printf("%s\n", line.c_str());
  std::printf("%s\n", verdict_text(result).c_str());
}

}  // namespace roadbalance
