#include "tools/study/encoder_study.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace roadbalance {
namespace {

TEST(EncoderStudy, EveryRowIsMetLiveAndOffline) {
  std::set<std::string> names;
  for (const EncoderRow& row : encoder_rows()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    const nlohmann::ordered_json result = encoder_row_result(row);
    EXPECT_TRUE(result["met"].get<bool>()) << result.dump();
  }
  EXPECT_EQ(names.size(), 11U);
}

// Jitter that is not in the train must not be measured; jitter that is cannot vanish.
TEST(EncoderStudy, MeasuresTheErrorThatIsThere) {
  EncoderRow row = encoder_rows().front();
  row.seconds = 12.0;
  row.from_s = 8.0;
  const auto error = [&](double jitter_s) {
    row.train.jitter_s = jitter_s;
    return live_errors(row, row.train.edges(0.0, row.seconds)).rms_deg;
  };
  const double none = error(0.0), some = error(20e-6);
  // Two stamps of 1 ns and what ten seconds of learning leave of 0.3 degrees.
  EXPECT_LT(none, 0.002);
  // 20 us are 0.13 degrees; the longest window averages no more than 240 teeth and their table.
  EXPECT_GT(some, 0.13 / std::sqrt(240.0));
}

TEST(EncoderStudy, ARowThatIsNotMetIsSaid) {
  EncoderRow row = encoder_rows().front();
  row.seconds = 6.0;
  row.from_s = 3.0;
  row.allowed_rms_deg = 1e-6;
  EXPECT_FALSE(encoder_row_result(row)["met"].get<bool>());
  row.allowed_rms_deg = row.allowed_max_deg = 10.0;
  EXPECT_TRUE(encoder_row_result(row)["met"].get<bool>());
  row.train.angle_rad = [](double t) { return t < 4.0 ? 100.0 * t : 400.0; };  // stands: no angle
  EXPECT_FALSE(encoder_row_result(row)["met"].get<bool>());
}

}  // namespace
}  // namespace roadbalance
