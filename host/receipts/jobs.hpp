#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/job.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/recording.hpp"
#include "common/process/child.hpp"
#include "common/process/temporary_folder.hpp"
#include "host/receipts/job_table.hpp"

namespace roadbalance {

/// Does with finished recordings what a person asks: one thing at a time, each a program of its own, which is
/// held while a recording is under way, for the disk is the recorder's.  Recordings are neither changed nor
/// deleted.  Each request acts once, however often it comes.
class Jobs {
 public:
  /// @param rb      the program
  /// @param folder  of the recordings
  /// @throws std::system_error if there is no place for what jobs write
  Jobs(std::filesystem::path rb, const std::filesystem::path& folder);

  /// @param known  the recordings there are
  /// @param grows  one of them is under way
  /// @return nothing: it is asked of somebody else
  std::optional<Answer> take(const Request& request, const std::vector<RecordingReceipt>& known, bool grows,
                             std::int64_t utc_us);
  /// To be called often.
  void turn(bool grows, std::int64_t utc_us);

  /// The newest, a single one with jobs = 0 of none.
  std::vector<Job> told() const;
  /// What is to be said of documents now: a new one whole, and part by part all there are, again and again,
  /// for who came late or missed one.
  std::vector<DocumentPart> said();

 private:
  struct Entry {
    Job job;
    std::string document{};
    bool is_said = false;
  };
  struct Running {
    std::size_t place;
    Child child;
    std::filesystem::path page;
    double bytes_to_read;
    bool is_cancelled = false;
    std::int64_t cancelled_us = 0;
  };
  Answer begin(const Request& request, const std::vector<RecordingReceipt>& known, bool grows,
               std::int64_t utc_us);
  Answer cancel(const Request& request, std::int64_t utc_us);
  void finish(int code, std::int64_t utc_us);

  const std::filesystem::path rb_, folder_;
  const TemporaryFolder work_{"rb-recordings"};
  std::deque<Answer> answered_;
  std::vector<Entry> entry_;  // by place
  std::size_t begun_ = 0;
  std::size_t next_said_ = 0;
  std::optional<Running> running_;
};

}  // namespace roadbalance
