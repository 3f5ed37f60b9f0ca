#include "tools/study/encoder_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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

// Marks that all come 100 us late, 0.65 degrees at 18 turns a second, put every angle off by as much, and
// nothing else.
TEST(EncoderStudy, TellsWhatTheMarksThemselvesAreOff) {
  EncoderRow row = encoder_rows().front();
  row.train.jitter_s = 0.0;
  row.seconds = 6.0;
  row.from_s = 3.0;
  std::vector<Edge> edges = row.train.edges(0.0, row.seconds);
  for (Edge& edge : edges)
    if (edge.kind == EdgeKind::kZeroMark) edge.time += NodeClock::duration(100'000);
  std::ranges::stable_sort(edges, {}, &Edge::time);
  for (const AngleErrors& errors : {live_errors(row, edges), offline_errors(row, edges)}) {
    EXPECT_NEAR(errors.all.rms_deg, 360.0 * 18.0 * 100e-6, 0.02);
    EXPECT_LT(errors.but_for_marks.rms_deg, 0.02);
  }
}

TEST(EncoderStudy, ManyRunsAreAsGoodAsTheirWorst) {
  EncoderRow row = encoder_rows().front();
  row.seconds = 6.0;
  row.from_s = 3.0;
  const auto one = encoder_row_result(row);
  EncoderRow next = row;
  ++next.train.seed;
  const auto other = encoder_row_result(next), both = encoder_row_result(row, 2);
  const auto value = [](const nlohmann::ordered_json& result, const char* key) {
    return result[key].get<double>();
  };
  EXPECT_DOUBLE_EQ(value(both, "max_deg"), std::max(value(one, "max_deg"), value(other, "max_deg")));
  EXPECT_NEAR(value(both, "rms_deg"),
              std::hypot(value(one, "rms_deg"), value(other, "rms_deg")) / std::sqrt(2.0), 1e-9);
  EXPECT_EQ(both["runs"], 2);
  row.allowed_rms_deg = 0.5 * (value(one, "rms_deg") + value(other, "rms_deg"));
  row.allowed_max_deg = 10.0;
  const auto mixed = encoder_row_result(row, 2);
  EXPECT_LT(mixed["runs_met"].get<int>(), 2);
  EXPECT_FALSE(mixed["met"].get<bool>());
}

// Jitter that is not in the train must not be measured; jitter that is cannot vanish.
TEST(EncoderStudy, MeasuresTheErrorThatIsThere) {
  EncoderRow row = encoder_rows().front();
  row.seconds = 12.0;
  row.from_s = 8.0;
  const auto error = [&](double jitter_s) {
    row.train.jitter_s = jitter_s;
    return live_errors(row, row.train.edges(0.0, row.seconds)).all.rms_deg;
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
