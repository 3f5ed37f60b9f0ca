#include "common/bus/recording.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

RecordingSummary receipt() {
  RecordingSummary sent{.number = 1, .recordings = 2, .name = "drive1", .vehicle = "a car"};
  sent.state = RecordingState::kIncomplete;
  sent.place = "/var/lib/drives";
  sent.first_us = 10;
  sent.last_us = 20;
  sent.bytes = 30;
  sent.refused = 4;
  sent.damaged_bytes = 5;
  sent.rate_hz = 2000.5;
  sent.cutoff_hz = 200.25;
  sent.most_reduction = 4;
  sent.node = {{1, 1000, 2, 3, 60.0, 0.5, 12e-6}, {2, 900, 0, 0, 59.0, 0.0, -1.0}};
  sent.mark = {{15, "weights fitted", 3}};
  sent.marks = 1;
  sent.verdict = "incomplete, every gap declared";
  return sent;
}

TEST(Recording, ComesBackAsItWasSent) {
  const auto bytes = encode(receipt());
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_recording(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->number, 1);
  EXPECT_EQ(got->recordings, 2);
  EXPECT_EQ(got->name, "drive1");
  EXPECT_EQ(got->vehicle, "a car");
  EXPECT_EQ(got->place, "/var/lib/drives");
  EXPECT_EQ(got->state, RecordingState::kIncomplete);
  EXPECT_EQ(got->first_us, 10);
  EXPECT_EQ(got->last_us, 20);
  EXPECT_EQ(got->bytes, 30);
  EXPECT_EQ(got->refused, 4);
  EXPECT_EQ(got->damaged_bytes, 5);
  EXPECT_EQ(got->rate_hz, 2000.5);
  EXPECT_EQ(got->cutoff_hz, 200.25);
  EXPECT_EQ(got->most_reduction, 4);
  ASSERT_EQ(got->node.size(), 2U);
  EXPECT_EQ(got->node[0].samples, 1000);
  EXPECT_EQ(got->node[0].samples_lost, 2);
  EXPECT_EQ(got->node[0].repaired, 3);
  EXPECT_EQ(got->node[0].seconds, 60.0);
  EXPECT_EQ(got->node[0].overload_s, 0.5);
  EXPECT_EQ(got->node[0].sync_residual_s, 12e-6);
  EXPECT_EQ(got->node[1].node, 2);
  ASSERT_EQ(got->mark.size(), 1U);
  EXPECT_EQ(got->mark[0].time_us, 15);
  EXPECT_EQ(got->mark[0].text, "weights fitted");
  EXPECT_EQ(got->mark[0].number, 3);
  EXPECT_EQ(got->marks, 1);
  EXPECT_EQ(got->verdict, "incomplete, every gap declared");
}

TEST(Recording, OfMoreNodesAndMarksTellsTheFirst) {
  RecordingSummary sent = receipt();
  for (std::int32_t k = 3; k <= 20; ++k) {
    sent.node.push_back({.node = k});
    sent.mark.push_back({k, "m"});
  }
  sent.marks = 19;
  const auto got = decode_recording(encode(sent));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->node.size(), kMostReceiptNodes);
  EXPECT_EQ(got->mark.size(), kMostReceiptMarks);
  EXPECT_EQ(got->marks, 19);
}

TEST(Recording, RefusesWhatCannotBe) {
  const auto taken = [](auto spoil) {
    RecordingSummary sent = receipt();
    spoil(sent);
    return decode_recording(encode(sent)).has_value();
  };
  for (const std::int32_t number : {-1, 2})
    EXPECT_FALSE(taken([&](auto& sent) { sent.number = number; })) << number;
  for (const std::int32_t state : {-1, 6})
    EXPECT_FALSE(taken([&](auto& sent) { sent.state = static_cast<RecordingState>(state); })) << state;
  EXPECT_FALSE(taken([](auto& sent) { sent.recordings = kMostRecordings + 1; }));
  EXPECT_FALSE(taken([](auto& sent) { sent.marks = -1; }));
}

}  // namespace
}  // namespace roadbalance
