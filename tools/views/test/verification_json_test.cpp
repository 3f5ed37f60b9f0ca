#include "tools/views/verification_json.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

// Of two nodes whose epochs lack nothing one ended early.
Verification with_absence() {
  Verification result;
  result.verdict = Verdict::kIncomplete;
  for (const std::int32_t node : {1, 2}) {
    VerifiedEpoch& epoch = result.epoch.emplace_back();
    epoch.node = node;
    epoch.ended = true;
  }
  result.absent = {{.node = 2, .text = "node 2 (rear) ended 38 s before the recording"}};
  return result;
}

TEST(VerificationJson, CallsNoNodeCompleteThatWasAbsent) {
  const auto json = verification_json(with_absence());
  EXPECT_EQ(json["nodes"][0]["complete"], true);
  EXPECT_EQ(json["nodes"][0]["absent"], false);
  EXPECT_EQ(json["nodes"][1]["complete"], false);
  EXPECT_EQ(json["nodes"][1]["absent"], true);
}

TEST(VerificationJson, PrintsThatANodeWasAbsentInItsLine) {
  testing::internal::CaptureStdout();
  print_verification(with_absence());
  const std::string printed = testing::internal::GetCapturedStdout();
  EXPECT_NE(printed.find("node 1 epoch 0: 0 blocks, 0 samples of 0, 0 gaps, complete\n"), std::string::npos);
  EXPECT_NE(printed.find("node 2 epoch 0: 0 blocks, 0 samples of 0, 0 gaps, was absent\n"),
            std::string::npos);
}

}  // namespace
}  // namespace roadbalance
