#include <gtest/gtest.h>

#include <memory>
#include <stop_token>

#include "host/recording/verify/verify.hpp"
#include "tools/import/test/import_fixture.hpp"

// An import is made whole or not at all, and in the order of time.
namespace roadbalance {
namespace {

TEST_F(ImportSamples, LeavesNothingOfAnImportThatFailed) {
  write("occupied", "a file");
  EXPECT_THROW(import_samples({.samples = write("s.csv", samples(100, uniform)),
                               .pulses = {},
                               .folder = folder_ / "occupied" / "record"},
                              two_nodes()),
               std::exception);
  // Its name is so long that the folder can be filled, but not named.
  const std::string name(252, 'n');
  EXPECT_THROW(import_samples(
                   {.samples = write("s.csv", samples(100, uniform)), .pulses = {}, .folder = folder_ / name},
                   two_nodes()),
               std::exception);
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_FALSE(entry.is_directory()) << entry.path();
}

/// Other numbers at each pass, as of a file that is still being written.
class ChangingSamples final : public SampleSource {
 public:
  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return 0.5; }
  void rewind() override {
    is_read_ = false;
    value_ += 1.0;
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    for (std::size_t i = 0; i < 100 && !is_read_; ++i) {
      rows.time_s.push_back(uniform(i));
      rows.value.insert(rows.value.end(), channel_.size(), value_);
    }
    is_read_ = true;
    return rows.rows() > 0;
  }

 private:
  const std::vector<FileChannel> channel_{{.name = "first_up", .unit = "m/s^2"},
                                          {.name = "second_up", .unit = "m/s^2"}};
  double value_ = 0.0;
  bool is_read_ = false;
};

TEST_F(ImportSamples, LeavesNothingOfAFileThatIsWrittenToMeanwhile) {
  const test::TemporaryDirectory other;
  std::ofstream(other.path() / "growing.csv") << "time_s\n";
  const SampleImport import{.samples = other.path() / "growing.csv",
                            .folder = folder_ / "record",
                            .open = [](const fs::path&) { return std::make_unique<ChangingSamples>(); }};
  try {
    import_samples(import, two_nodes());
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("growing.csv: was written to while it was read"),
              std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(ImportSamples, TellsItsProgressAndStopsWhenAsked) {
  std::stop_source stop;
  double last = 0.0;
  const auto progress = [&](double part) {
    EXPECT_GE(part, last);
    EXPECT_LE(part, 1.0);
    if (last < 0.7 && part >= 0.7) stop.request_stop();
    last = part;
  };
  const SampleImport import{.samples = write("s.csv", samples(20'000, uniform)),
                            .folder = folder_ / "record"};
  EXPECT_THROW(import_samples(import, two_nodes(), stop.get_token(), progress), std::runtime_error);
  EXPECT_GE(last, 0.7);
  EXPECT_LT(last, 1.0);
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_FALSE(entry.is_directory()) << entry.path();
}

// A node that has no samples for long holds up no other, and none of the others' are held for it.
TEST_F(ImportSamples, GoesOnWithoutANodeThatPauses) {
  std::string text = "time_s,second_up,first_up\ns,g,m/s^2\n";
  constexpr int kRows = 20'000, kFrom = 1'000, kTo = 19'000;
  for (int i = 0; i < kRows; ++i)
    text += std::to_string(uniform(static_cast<std::size_t>(i))) + (i < kFrom || i >= kTo ? ",0.5," : ",,") +
            "0.1\n";
  import_samples({.samples = write("s.csv", text), .folder = folder_ / "record"}, two_nodes());
  const Verification verification = verify_record(folder_ / "record");
  EXPECT_EQ(verification.verdict, Verdict::kIncomplete);
  ASSERT_EQ(verification.epoch.size(), 2U);
  EXPECT_EQ(verification.epoch[0].samples, kRows);
  EXPECT_EQ(verification.epoch[1].samples, kRows - (kTo - kFrom));
}

/// Rows 0 to `rows` of two nodes, in which the second has its cells where `is_there` says so.
std::string with_second(int rows, const std::function<bool(int row)>& is_there) {
  std::string text = "time_s,second_up,first_up\ns,g,m/s^2\n";
  for (int i = 0; i < rows; ++i)
    text += std::to_string(uniform(static_cast<std::size_t>(i))) + (is_there(i) ? ",0.5," : ",,") + "0.1\n";
  return text;
}

// Whole blocks and parts of one, a single row that is missing, and a single one that is there.
TEST_F(ImportSamples, DeclaresWhatANodeLacksAtBothEnds) {
  constexpr int kRows = 2'000;
  for (const auto& [from, to] :
       {std::pair{600, kRows}, {0, 1'500}, {601, 1'499}, {1, kRows - 1}, {610, 611}}) {
    fs::remove_all(folder_ / "record");
    const std::string text = with_second(kRows, [&](int row) { return row >= from && row < to; });
    const ImportReport report =
        import_samples({.samples = write("s.csv", text), .folder = folder_ / "record"}, two_nodes());
    EXPECT_EQ(report.nodes.at(0).scans_missing, 0);
    EXPECT_EQ(report.nodes.at(1).scans, to - from);
    EXPECT_EQ(report.nodes.at(1).scans_missing, kRows - (to - from));
    const Verification verification = verify_record(folder_ / "record");
    EXPECT_EQ(verification.verdict, Verdict::kIncomplete);
    ASSERT_EQ(verification.epoch.size(), 2U);
    EXPECT_TRUE(verification.epoch[0].gaps.empty());
    const VerifiedEpoch& second = verification.epoch[1];
    EXPECT_TRUE(second.contradictions.empty());
    EXPECT_TRUE(second.undeclared_scans.empty());
    EXPECT_EQ(second.samples, to - from);
    std::vector<std::pair<std::int64_t, std::int64_t>> expected, found;
    if (from > 0) expected.emplace_back(0, from);
    if (to < kRows) expected.emplace_back(to, kRows - to);
    for (const VerifiedGap& gap : second.gaps) {
      EXPECT_EQ(gap.cause, GapCause::kSourceGap);
      found.emplace_back(gap.first_scan, gap.scans);
    }
    EXPECT_EQ(found, expected) << from << " to " << to;
    for (const SealedBlock& block : blocks_of_record()) {
      const bool is_placed =
          block.kind == BlockKind::kScan || block.kind == BlockKind::kGap || block.kind == BlockKind::kEnd;
      if (block.header.node != 2 || !is_placed) continue;
      const auto scan = static_cast<std::size_t>(block.header.first_scan);
      EXPECT_NEAR(static_cast<double>(block.header.time_ns), 1e9 * uniform(scan), 2.0) << scan;
    }
  }
}

TEST_F(ImportSamples, CountsAHoleOfTheFileBesideWhatANodeLacksAtItsBegin) {
  std::string text = "time_s,second_up,first_up\ns,g,m/s^2\n";
  for (const int i : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9})
    for (int k = 0; k < 100; ++k) {
      const int row = 100 * i + k + (i > 0 ? 900 : 0);
      text +=
          std::to_string(uniform(static_cast<std::size_t>(row))) + (row < 1'200 ? ",," : ",0.5,") + "0.1\n";
    }
  import_samples({.samples = write("s.csv", text), .folder = folder_ / "record"}, two_nodes());
  const Verification verification = verify_record(folder_ / "record");
  ASSERT_EQ(verification.epoch.size(), 2U);
  EXPECT_EQ(verification.epoch[0].samples_missing, 900);
  EXPECT_EQ(verification.epoch[1].samples_missing, 1'200);
  EXPECT_EQ(verification.epoch[1].samples_sent, verification.epoch[0].samples_sent);
}

TEST_F(ImportSamples, RefusesANodeWithoutAnySample) {
  const std::string error = error_of(with_second(200, [](int) { return false; }), two_nodes());
  EXPECT_NE(error.find("s.csv: node second has no sample: each of second_up is empty"), std::string::npos)
      << error;
  EXPECT_NE(
      error.find("allowed: samples of each node, or a file and a vehicle's description without the node"),
      std::string::npos)
      << error;
  EXPECT_FALSE(fs::exists(folder_ / "record"));
}

}  // namespace
}  // namespace roadbalance
