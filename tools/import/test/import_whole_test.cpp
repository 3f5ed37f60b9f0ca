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

}  // namespace
}  // namespace roadbalance
