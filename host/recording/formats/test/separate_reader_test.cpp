#include "host/recording/formats/separate_reader.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>
#include <functional>
#include <stdexcept>
#include <system_error>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

using Rows = std::vector<double>;

constexpr int kRows = 25000;  ///< more than a pipe holds

/// kRows rows of two channels, whatever the file; `at_row` may spoil them.
class Counting final : public SampleSource {
 public:
  explicit Counting(std::function<void(int row)> at_row, const char* first = "front")
      : at_row_(std::move(at_row)), channel_{{first, "g", "left"}, {"", "", "", "m"}} {}
  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return static_cast<double>(row_) / kRows; }
  void rewind() override { row_ = 0; }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = 2;
    for (; row_ < kRows && rows.rows() < kRowsAtOnce; ++row_) {
      at_row_(row_);
      rows.time_s.push_back(row_);
      rows.value.insert(rows.value.end(), {-1.0 * row_, 0.5});
    }
    return rows.rows() > 0;
  }

 private:
  std::function<void(int row)> at_row_;
  std::vector<FileChannel> channel_;
  int row_ = 0;
};

OpenSamples spoiled(std::function<void(int row)> at_row) {
  return [at_row](const std::filesystem::path&) { return std::make_unique<Counting>(at_row); };
}

/// The values of all rows, in order.
Rows times_of(SampleSource& source) {
  Rows all;
  for (SampleRows rows; source.read(rows);) {
    for (std::size_t k = 0; k < rows.rows(); ++k) {
      EXPECT_EQ(rows.row(k)[0], -rows.time_s[k]);
      EXPECT_EQ(rows.row(k)[1], 0.5);
    }
    all.insert(all.end(), rows.time_s.begin(), rows.time_s.end());
  }
  return all;
}

std::string refusal(const OpenSamples& open, ReaderLimits limits = {}) {
  const auto source = read_separately("drive.h5", open, limits);
  try {
    times_of(*source);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

class SeparateReader : public ::testing::Test {
 protected:
  void TearDown() override {  // no process is left, however it ended
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
  }
};

TEST_F(SeparateReader, GivesTheSamplesAsOftenAsOneLikes) {
  const auto source = read_separately("drive.h5", spoiled([](int) {}));
  EXPECT_EQ(source->channels(), (std::vector<FileChannel>{{"front", "g", "left"}, {"", "", "", "m"}}));
  EXPECT_EQ(source->part(), 0.0);
  const Rows first = times_of(*source);
  ASSERT_EQ(first.size(), static_cast<std::size_t>(kRows));
  EXPECT_EQ(first.back(), kRows - 1.0);
  EXPECT_EQ(source->part(), 1.0);
  SampleRows none;
  EXPECT_FALSE(source->read(none));
  source->rewind();
  EXPECT_EQ(times_of(*source), first);
  source->rewind();
  EXPECT_TRUE(source->read(none));  // and it may be destroyed before it was read
}

TEST_F(SeparateReader, TellsWhatWentWrongInTheSameWords) {
  const OpenSamples refused = [](const auto& file) -> std::unique_ptr<SampleSource> {
    throw ConfigError(file.string() + ": no channel");
  };
  EXPECT_THROW(
      {
        try {
          read_separately("drive.h5", refused);
        } catch (const ConfigError& error) {
          EXPECT_STREQ(error.what(), "drive.h5: no channel");
          throw;
        }
      },
      ConfigError);
  EXPECT_EQ(refusal(spoiled([](int row) {
              if (row == 1500) throw ConfigError("row 1500: goes back");
            })),
            "row 1500: goes back");
  const auto source = read_separately("drive.h5", spoiled([](int row) {
                                        if (row == 1500) throw std::runtime_error("HDF5: no room");
                                      }));
  try {
    times_of(*source);
    FAIL();
  } catch (const ConfigError&) {
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "HDF5: no room");
  }
}

TEST_F(SeparateReader, NamesTheFileThatEndsItsReader) {
  EXPECT_EQ(refusal(spoiled([](int row) {
              if (row == 1500) raise(SIGKILL);
            })),
            "drive.h5: cannot be read, is perhaps damaged: reading it fails in the library: Killed");
  EXPECT_EQ(refusal(spoiled([](int row) {
              if (row == 1500) _exit(1);
            })),
            "drive.h5: cannot be read, is perhaps damaged: reading it fails in the library");
}

TEST_F(SeparateReader, NamesTheFileThatHoldsItsReaderForEver) {
  volatile bool for_ever = true;
  EXPECT_EQ(refusal(spoiled([&](int row) {
                      while (row == 1500 && for_ever) {
                      }
                    }),
                    {.processor_s = 1}),
            "drive.h5: cannot be read, is perhaps damaged: reading it does not get on, though a processor "
            "works at it");
}

TEST_F(SeparateReader, NamesTheFileWhoseReaderWaitsForEver) {
  EXPECT_EQ(refusal(spoiled([](int row) {
                      if (row == 1500) pause();
                    }),
                    {.wait_s = 1}),
            "drive.h5: cannot be read, is perhaps damaged: reading it does not get on: nothing came for 1 s");
}

TEST_F(SeparateReader, RefusesAFileThatHasOtherChannelsTheSecondTime) {
  bool is_other = false;
  const auto source = read_separately("drive.h5", [&](const auto&) -> std::unique_ptr<SampleSource> {
    return std::make_unique<Counting>([](int) {}, is_other ? "rear" : "front");
  });
  is_other = true;
  try {
    source->rewind();
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "drive.h5: has other channels than when it was opened; allowed: a file that is done");
  }
}

// The limit is for each part of the file, not for the whole.
TEST_F(SeparateReader, TakesItsTimeOverALongFile) {
  EXPECT_EQ(refusal(spoiled([](int row) {
                      if (row % 6000 != 0) return;
                      const std::clock_t until = std::clock() + CLOCKS_PER_SEC * 13 / 10;
                      while (std::clock() < until) {
                      }
                    }),
                    {.processor_s = 1}),
            "none");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their heaps ignore the limit
TEST_F(SeparateReader, NamesTheFileThatWouldTakeAllMemory) {
  EXPECT_EQ(refusal(spoiled([](int row) {
                      static std::vector<double> numbers;
                      if (row == 1500) numbers.resize(std::size_t{64} << 20);
                    }),
                    {.more_bytes = 256 << 20}),
            "drive.h5: cannot be read, is perhaps damaged: reading it takes more memory than it may");
}
#endif

}  // namespace
}  // namespace roadbalance
