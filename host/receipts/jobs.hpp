#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/job.hpp"
#include "common/bus/operation.hpp"
#include "common/process/child.hpp"
#include "common/process/temporary_folder.hpp"
#include "host/receipts/byte_rate.hpp"
#include "host/receipts/job_book_file.hpp"
#include "host/receipts/job_instant.hpp"
#include "host/receipts/job_table.hpp"
#include "host/receipts/recordings_list.hpp"

namespace roadbalance {

/// Where jobs put what they make.
struct JobPlaces {
  std::filesystem::path results;  ///< new recordings, exports and the book of jobs; made when it is needed
  std::filesystem::path transfer_to;  ///< copies; empty: nothing is to be transferred
};

/// Does with finished recordings what a person asks: one thing at a time, each a program of its own, which is
/// held while a recording is under way, for the disk is the recorder's.  Recordings are neither changed nor
/// deleted; what is made gets a name that is free.  Each request acts once, however often it comes.
///
/// A job that this program did not live to see the end of is told as interrupted when it begins again; the
/// same order begins it anew, or goes on with it if it is a transfer.  What stays on a disk is begun only
/// when it stands in the book: nothing that is left half made is without somebody who knows of it.
class Jobs {
 public:
  /// @param rb  the program
  /// @throws std::system_error if there is no place for what jobs write meanwhile
  Jobs(std::filesystem::path rb, const JobPlaces& places);

  /// @param known  the recordings there are
  /// @param grows  one of them is under way
  /// @return nothing: it is asked of somebody else
  std::optional<Answer> take(const Request& request, const std::vector<ListedRecording>& known, bool grows,
                             const JobInstant& now);
  /// To be called often.
  void turn(bool grows, const JobInstant& now);

  /// The newest, a single one with jobs = 0 of none.
  std::vector<Job> told() const;
  /// What is to be said of documents now: a new one whole, and part by part all there are, again and again,
  /// for who came late or missed one.
  std::vector<DocumentPart> said();

 private:
  struct Entry {
    BookedJob booked;
    std::string document{};
    bool is_said = false;
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
  std::size_t next_said_ = 0;
  std::optional<Running> running_;
  std::optional<WallTime> book_failed_{};  ///< it is not as the jobs are: to be written again
};

}  // namespace roadbalance
