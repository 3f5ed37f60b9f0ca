#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/publish.hpp"
#include "common/link/block.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/desk.hpp"
#include "host/recorder/heard_nodes.hpp"
#include "host/recorder/mark_readings.hpp"
#include "host/recorder/operate.hpp"
#include "host/recorder/rest_fetching.hpp"
#include "host/recorder/session.hpp"
#include "host/recorder/set_up.hpp"

namespace roadbalance {

/// The desk with its hands, without a bus: datagrams and time come in, datagrams go out, sessions are led.  A
/// pure state machine but for the disk that it is given.
class Operating {
 public:
  struct World {
    Disk& disk;
    std::function<std::unique_ptr<Session>(RecorderOptions)> begin;
    std::uint64_t seed;  ///< of request numbers and of what this recorder is called on the bus
  };
  struct Time {
    WallTime now{};
    std::int64_t utc_us = 0;
  };

  /// Reads the book and goes on with what it has under way.
  /// @throws std::runtime_error, std::system_error, ConfigError naming the file
  Operating(const OperateOptions& options, World world, Time time);

  /// What came on any channel; those of requests, heartbeats, clocks, replies, previews and, while
  /// a zero mark is read, blocks count.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, Time time);

  /// Does and says what is due.  False: told to stop, and nothing is left to be done.
  /// @throws std::runtime_error if it was told to stop and the recording ends with an error
  bool turn(bool told_to_stop, Time time, const Publish& publish);

  /// The epochs of all recordings.
  RecorderReport report() const { return report_; }
  /// Something is being recorded or set up, or is to be fetched.
  bool has_work() const {
    return session_ || is_set_up_under_way() || desk_.under_way() || !desk_.rests().empty();
  }
  /// There is none, and at the recordings' folder another disk was mounted: another Operating reads its book.
  bool has_another_disk() const;

 private:
  static constexpr std::chrono::milliseconds kAgain{1000};  ///< after what failed

  DeskBook with_vehicle(DeskBook book);
  Desk::Hands hands();
  Answer set_up(const Request& request);
  Answer read_mark(const Request& request);
  Answer no_vehicle(const Request& request) const;
  bool is_set_up_under_way() const { return set_up_ && set_up_->is_under_way(); }
  void hear_clock(std::span<const std::uint8_t> bytes);
  void note_marks();
  void begin(const UnderWay& recording);
  std::unique_ptr<Session> begin_rest(const std::string& recording, EpochScope scope);
  void look_after_recording();
  void look_after_rests();
  void owe_unknown_rests();
  std::vector<Rest> without_folder(const std::vector<Rest>& rests);
  void forget_rests_without_folder();
  void leave_rests_to_others();
  std::vector<std::int64_t> incarnations_of(const std::string& recording) const;
  bool has_had(const std::string& recording, std::int64_t incarnation) const;
  std::vector<IncarnationRange> former_incarnations() const;
  void require_its_folder();
  void follow_disk(bool fails);
  void know_book();
  void store(const DeskBook& book);
  void finish(const RecorderReport& report);
  void add_to_report(const RecorderReport& one);
  std::string who_differs() const;
  void tell_who_differs();
  bool session_speaks() const { return session_ && session_->view().status; }
  void say_status(const Publish& publish);
  void say_receipts(const Publish& publish);
  void warn(const std::string& sentence) const;

  const OperateOptions& options_;
  const World world_;
  File claim_;
  WallTime claimed_at_{};             // tried to
  std::string claim_fault_;           // why that failed
  std::set<std::string> book_texts_;  // one of which is on the disk
  Time time_;                         // of the call under way
  const std::int64_t recorder_;
  HeardNodes heard_{options_.recorder.nodes};
  std::map<std::int32_t, double> sync_us_;
  std::optional<SetUp> set_up_;
  std::string no_set_up_ = "this recorder leads no vehicle file: start rb-recorder with --vehicle FILE";
  SealedBlock block_;
  MarkReadings mark_readings_;
  std::atomic<int> nodes_recorded_ = 0;  // before the session, whose thread reads it
  std::mutex differs_mutex_;
  WallTime agreed_at_{};
  std::string differs_;              // who measures by another file, for the session
  std::vector<NoteToRecord> marks_;  // that wait to be noted
  std::unique_ptr<Session> session_;
  RestFetching rests_;
  RecorderReport report_;
  bool has_samples_ = false;  // the recording under way, on the disk
  bool ends_ = false;
  WallTime failed_at_{};
  WallTime written_again_at_{};
  WallTime ended_at_{time_.now};  // the last recording did, or this recorder began
  WallTime status_at_{};
  WallTime receipts_at_{};
  Desk desk_;  // last: it may have its hands do something at once
};

}  // namespace roadbalance
