#include "common/bus/job.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roadbalance {
namespace {

Job job() {
  return {.place = 1,
          .jobs = 3,
          .job = 1'700'000'000'000'000,
          .kind = JobKind::kReport,
          .state = JobState::kNotWell,
          .recording = "second",
          .options = "before=first",
          .began_us = 5,
          .ended_us = 7,
          .elapsed_s = 2.5,
          .progress = 0.25,
          .bytes = 2'500'000'000,
          .bytes_to_read = 10'000'000'000,
          .bytes_per_s = 45e6,
          .document_kind = DocumentKind::kPage,
          .parts = 6,
          .transfer_to = "/media/disk",
          .text = "no wheel is known"};
}

TEST(Job, ComesBackAsItWasSent) {
  const auto bytes = encode(job());
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_job(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->place, 1);
  EXPECT_EQ(got->jobs, 3);
  EXPECT_EQ(got->job, 1'700'000'000'000'000);
  EXPECT_EQ(got->kind, JobKind::kReport);
  EXPECT_EQ(got->state, JobState::kNotWell);
  EXPECT_EQ(got->recording, "second");
  EXPECT_EQ(got->options, "before=first");
  EXPECT_EQ(got->began_us, 5);
  EXPECT_EQ(got->ended_us, 7);
  EXPECT_EQ(got->elapsed_s, 2.5);
  EXPECT_EQ(got->progress, 0.25);
  EXPECT_EQ(got->bytes, 2'500'000'000);
  EXPECT_EQ(got->bytes_to_read, 10'000'000'000);
  EXPECT_EQ(got->bytes_per_s, 45e6);
  EXPECT_EQ(got->transfer_to, "/media/disk");
  EXPECT_EQ(got->document_kind, DocumentKind::kPage);
  EXPECT_EQ(got->parts, 6);
  EXPECT_EQ(got->text, "no wheel is known");
}

TEST(Job, IsRefusedWhenItCannotBe) {
  const auto refused = [](auto&& change) {
    Job wrong = job();
    change(wrong);
    return !decode_job(encode(wrong));
  };
  EXPECT_FALSE(refused([](Job&) {}));
  EXPECT_TRUE(refused([](Job& j) { j.place = 3; }));
  EXPECT_TRUE(refused([](Job& j) { j.jobs = kMostJobs + 1; }));
  EXPECT_TRUE(refused([](Job& j) { j.kind = static_cast<JobKind>(0); }));
  EXPECT_TRUE(refused([](Job& j) { j.state = static_cast<JobState>(8); }));
  EXPECT_TRUE(refused([](Job& j) { j.progress = std::nan(""); }));
  EXPECT_TRUE(refused([](Job& j) { j.parts = kMostParts + 1; }));
  EXPECT_TRUE(refused([](Job& j) { j.bytes = -1; }));
  EXPECT_TRUE(refused([](Job& j) { j.bytes_per_s = HUGE_VAL; }));
  EXPECT_TRUE(decode_job(encode(Job{}))) << "that there is none";
}

TEST(Document, IsWholeAgainFromItsParts) {
  std::string document;
  for (int k = 0; k < 1000; ++k) document += "größe " + std::to_string(k) + "\n";
  const auto parts = parts_of(document, 2, 99);
  ASSERT_EQ(parts.size(), (document.size() + kPartBytes - 1) / kPartBytes);
  std::string joined;
  for (const auto& part : parts) {
    const auto bytes = encode(part);
    EXPECT_LT(bytes.size(), 1400U) << "one datagram";
    const auto got = decode_document_part(bytes);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->place, 2);
    EXPECT_EQ(got->job, 99);
    EXPECT_EQ(got->parts, static_cast<std::int32_t>(parts.size()));
    joined += got->bytes;
  }
  EXPECT_EQ(joined, document);
  EXPECT_TRUE(parts_of("", 0, 1).empty());
}

TEST(Document, RefusesAPartThatCannotBe) {
  const DocumentPart good{.place = 0, .job = 1, .part = 1, .parts = 2, .bytes = "x"};
  EXPECT_TRUE(decode_document_part(encode(good)));
  auto wrong = good;
  wrong.part = 2;
  EXPECT_FALSE(decode_document_part(encode(wrong)));
  wrong = good;
  wrong.place = kMostJobs;
  EXPECT_FALSE(decode_document_part(encode(wrong)));
  wrong = good;
  wrong.bytes = "";
  EXPECT_FALSE(decode_document_part(encode(wrong)));
}

}  // namespace
}  // namespace roadbalance
