#include "tools/rb/study_encoder.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/rb/command.hpp"
#include "tools/study/encoder_study.hpp"
#include "tools/study/phase_injection.hpp"
#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

void print_errors(const nlohmann::ordered_json& row, const std::string& prefix) {
  const std::string rms = prefix + "rms_deg", max = prefix + "max_deg";
  if (!row.contains(rms)) return;
  if (row[max].is_null())
    std::printf("  %.4f /   any ", row[rms].get<double>());
  else
    std::printf("  %.4f / %.4f", row[rms].get<double>(), row[max].get<double>());
}

void print_runs(const nlohmann::ordered_json& row) {
  const int runs = row["runs"].get<int>();
  std::printf("  worst run %.4f", row["worst_run_rms_deg"].get<double>());
  if (const int met = row["runs_met"].get<int>(); met < runs)
    std::printf(", met by %d of %d runs, by %d but for what their zero marks are off", met, runs,
                row["runs_met_but_for_marks"].get<int>());
}

void print_row(const nlohmann::ordered_json& row) {
  std::printf("%s %-68s", row["met"].get<bool>() ? "met    " : "NOT MET",
              row["case"].get<std::string>().c_str());
  for (const char* const prefix : {"allowed_", "", "offline_"}) print_errors(row, prefix);
  if (const int unknown = row["unknown_blocks"].get<int>(); unknown > 0)
    std::printf("  %d blocks without an angle", unknown);
  if (row.value("runs", 1) > 1) print_runs(row);
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int study_encoder(const EncoderStudyOptions& options) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bool met = true;
  const auto add = [&](const nlohmann::ordered_json& row) {
    met = met && row["met"].get<bool>();
    if (!options.json && !options.markdown) print_row(row);
    rows.push_back(row);
  };
  if (!options.json && !options.markdown)
    std::printf("        %-68s %17s %17s %17s\n", "angle error in degrees, rms / max", "allowed", "live",
                "offline");
  for (EncoderRow& row : encoder_rows()) {
    if (options.seed) row.train.seed = *options.seed;
    add(encoder_row_result(row, options.runs));
  }
  for (const auto& row : phase_injection_rows()) add(row);
  if (options.json) std::printf("%s\n", nlohmann::ordered_json{{"rows", rows}, {"met", met}}.dump().c_str());
  if (options.markdown)
    std::printf("%s", markdown_tables(nlohmann::ordered_json{
                                          {"tables", {{{"title", "Angle errors, degrees"}, {"rows", rows}}}}})
                          .c_str());
  return met ? kDone : kAnswerIsNo;
}

}  // namespace roadbalance
