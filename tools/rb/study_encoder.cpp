#include "tools/rb/study_encoder.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/rb/command.hpp"
#include "tools/study/encoder_study.hpp"

namespace roadbalance {

int study_encoder(bool json) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bool met = true;
  if (!json)
    std::printf("        %-68s %17s %17s %17s\n", "angle error in degrees, rms / max", "allowed", "live",
                "offline");
  for (const EncoderRow& row : encoder_rows()) {
    nlohmann::ordered_json result = encoder_row_result(row);
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
      std::printf("\n");
      std::fflush(stdout);
    }
    rows.push_back(std::move(result));
  }
  if (json) std::printf("%s\n", nlohmann::ordered_json{{"rows", rows}, {"met", met}}.dump().c_str());
  return met ? kDone : kAnswerIsNo;
}

}  // namespace roadbalance
