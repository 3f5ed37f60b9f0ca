#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/job.hpp"
#include "common/bus/operation.hpp"
#include "common/clock/utc.hpp"
#include "common/process/child.hpp"
#include "common/process/temporary_folder.hpp"
#include "common/types/clocks.hpp"
#include "host/recordings/byte_rate.hpp"
#include "host/recordings/job_book.hpp"
#include "host/recordings/job_table.hpp"
#include "host/recordings/recordings_list.hpp"

namespace roadbalance {

/// An instant in UTC, for people, and on a clock that never steps, for durations.
struct JobInstant {
  std::int64_t utc_us = 0;
  WallTime steady{};

  static JobInstant now() { return {roadbalance::utc_us(), WallClock::now()}; }
};

/// Where jobs put what they make.
struct JobPlaces {
  std::filesystem::path results;      ///< for new recordings, exports and the book of jobs; made when needed
  std::filesystem::path transfer_to;  ///< for copies; empty: transfers are refused
};

/// Runs the jobs that people ask for on finished recordings: one at a time, each in a process of its own,
/// which is held while a recording is under way, since the disk is the recorder's.  Recordings are neither
/// changed nor deleted; results get a free name.  Each request acts once, however often it comes.
///
/// A job that was under way when this program ended is reported as interrupted at the next start; the same
/// order begins it anew, or resumes it if it is a transfer.  A job that leaves something on a disk begins
/// only when it stands in the book, so that no unfinished result is forgotten.
class Jobs {
 public:
  /// @param rb  the program
  /// @throws std::system_error if no folder for temporary files can be made
  Jobs(std::filesystem::path rb, const JobPlaces& places);

  /// @param known  the recordings there are
  /// @param grows  one of them is under way
  /// @return nothing: the request is for another program
  std::optional<Answer> take(const Request& request, const std::vector<ListedRecording>& known, bool grows,
                             const JobInstant& now);
  /// To be called often.
  void turn(bool grows, const JobInstant& now);

  /// The newest jobs as messages; without any a single one with jobs = 0.
  std::vector<Job> reported() const;
  /// The parts of documents to send now: a new document whole, and one part of all in turn, again and again,
  /// for pages that came late or missed one.
  std::vector<DocumentPart> due_parts();

 private:
  struct Entry {
    BookedJob booked;
    std::string document{};
    bool is_sent = false;
  };
  struct Running {
    std::size_t place;
    JobLine line;
    WallTime began;
    Child child;
    std::filesystem::path page{};
    ByteRate rate{};
    std::optional<WallTime> cancelled = {};
  };
  Answer begin(const Request& request, const std::vector<ListedRecording>& known, bool grows,
               const JobInstant& now);
  Answer cancel(const Request& request, const JobInstant& now);
  void run(const JobLine& line, const JobOrder& order, const ListedRecording& recording,
           const ListedRecording* before, BookedJob booked, const std::vector<ListedRecording>& known,
           WallTime now);
  void finish(int code, const JobInstant& now);
  void take_document(Entry& entry) const;
  void read_book();
  void write_book(const std::vector<Entry>& entries) const;
  void try_write_book(WallTime now);

  const std::filesystem::path rb_;
  const JobPlaces places_;
  const JobBookFile book_;
  const TemporaryFolder work_{"rb-recordings"};
  std::deque<Answer> answered_;
  std::vector<Entry> entry_;  // by place
  std::size_t begun_ = 0;
  std::size_t next_reported_ = 0;
  std::optional<Running> running_;
  std::optional<WallTime> book_failed_{};  ///< the book lags behind the jobs: to be written again
};

}  // namespace roadbalance
