#include "tools/rb/study_encoder.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/rb/command.hpp"
#include "tools/study/encoder_study.hpp"

namespace roadbalance {
namespace {

void print_runs(const nlohmann::ordered_json& result) {
  const int runs = result["runs"].get<int>();
  std::printf("  worst run %.4f", result["worst_run_rms_deg"].get<double>());
  if (const int met = result["runs_met"].get<int>(); met < runs)
    std::printf(", met by %d of %d runs, by %d but for what their zero marks are off", met, runs,
                result["runs_met_but_for_marks"].get<int>());
}

}  // namespace

int study_encoder(const EncoderStudyOptions& options) {
  const bool json = options.json;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bool met = true;
  if (!json)
    std::printf("        %-68s %17s %17s %17s\n", "angle error in degrees, rms / max", "allowed", "live",
                "offline");
  for (EncoderRow& row : encoder_rows()) {
    if (options.seed) row.train.seed = *options.seed;
    nlohmann::ordered_json result = encoder_row_result(row, options.runs);
    met = met && result["met"].get<bool>();
    if (!json) {
      const auto cell = [&](const char* rms, const char* max) {
        if (result[max].is_null())
          std::printf("  %.4f /   any ", result[rms].get<double>());
        else
          std::printf("  %.4f / %.4f", result[rms].get<double>(), result[max].get<double>());
      };
      std::printf("%s %-68s", result["met"].get<bool>() ? "met    " : "NOT MET", row.name.c_str());
      cell("allowed_rms_deg", "allowed_max_deg");
      cell("rms_deg", "max_deg");
      cell("offline_rms_deg", "offline_max_deg");
      if (const int unknown = result["unknown_blocks"].get<int>(); unknown > 0)
        std::printf("  %d blocks without an angle", unknown);
      if (options.runs > 1) print_runs(result);
      std::printf("\n");
      std::fflush(stdout);
    }
    rows.push_back(std::move(result));
  }
  if (json) std::printf("%s\n", nlohmann::ordered_json{{"rows", rows}, {"met", met}}.dump().c_str());
  return met ? kDone : kAnswerIsNo;
}

}  // namespace roadbalance
