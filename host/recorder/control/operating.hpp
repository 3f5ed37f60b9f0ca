#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/publish.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/control/heard_nodes.hpp"
#include "host/recorder/control/operate.hpp"
#include "host/recorder/control/pending_fetch.hpp"
#include "host/recorder/control/recordings_folder.hpp"
#include "host/recorder/control/session.hpp"
#include "host/recorder/control/session_controller.hpp"
#include "host/recorder/control/vehicle_requests.hpp"

namespace roadbalance {

/// A SessionController with its callbacks, without a bus: datagrams and time come in, datagrams go out,
/// sessions are led.  A pure state machine but for the disk that it is given.
class Operating {
 public:
  struct World {
    Disk& disk;
    std::function<std::unique_ptr<Session>(RecorderOptions)> begin;
    std::uint64_t seed;  ///< of request numbers and of what this recorder is called on the bus
    /// Memory for so many nodes, before a start waits for it.
    std::function<void(std::size_t nodes)> provide = [](std::size_t) {};
  };
  struct Time {
    WallTime now{};
    std::int64_t utc_us = 0;
    MachineClock::duration slept{};  ///< as MachineClock::slept()
  };

  /// Reads the session state and goes on with what it has under way.
  /// @throws std::runtime_error, std::system_error, ConfigError naming the file
  Operating(const OperateOptions& options, World world, Time time);

  /// Takes a message of any channel; requests, heartbeats, clocks, replies, previews and, while a zero mark
  /// is read, blocks count.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, Time time);

  /// Does and sends what is due. @return false: a stop was requested, and nothing is left to be done
  /// @throws std::runtime_error if a stop was requested and the recording ends with an error
  bool turn(bool stop_requested, Time time, const Publish& publish);

  /// The epochs of all recordings.
  RecorderReport report() const { return report_; }
  /// Something is being recorded or set up, or is to be fetched.
  bool has_work() const {
    return session_ || vehicle_.is_set_up_under_way() || controller_.active() ||
           !controller_.pending().empty();
  }
  /// There is none, and at the recordings' folder another disk was mounted: another Operating reads its
  /// state.
  bool has_another_disk() const { return !has_work() && folder_.is_on_another_disk(); }

 private:
  static constexpr std::chrono::milliseconds kAgain{1000};  ///< after what failed

  SessionController::Callbacks callbacks();
  void hear_clock(std::span<const std::uint8_t> bytes);
  void note_marks();
  void begin(const ActiveRecording& recording);
  std::vector<ExpectedNode> expected() const;
  std::vector<ExpectedNode> expected_of(const std::vector<std::int32_t>& chosen) const;
  ChosenNodes choose(const std::string& nodes) const;
  void provide();
  void look_after_recording();
  void set_time(const Time& time);
  void finish(const RecorderReport& report);
  void add_to_report(const RecorderReport& one);
  std::string who_differs() const;
  void report_who_differs();
  bool session_speaks() const { return session_ && session_->view().status; }
  void send_status(const Publish& publish);
  void send_receipts(const Publish& publish);
  void warn(const std::string& sentence) const;

  const OperateOptions& options_;
  const World world_;
  RecordingsFolder folder_;
  Time time_;  // of the call under way
  const std::int64_t recorder_;
  mutable HeardNodes heard_{options_.recorder.nodes};
  std::map<std::int32_t, double> sync_us_;
  VehicleRequests vehicle_;
  std::atomic<int> nodes_recorded_ = 0;         // before the session, whose thread reads it
  std::atomic<std::int64_t> clock_set_us_ = 0;  // the same, of the recording under way
  std::mutex differs_mutex_;
  WallTime agreed_at_{};
  std::string differs_;              // who measures by another file, for the session
  std::vector<NoteToRecord> marks_;  // that wait to be noted
  std::unique_ptr<Session> session_;
  PendingFetch fetch_;
  RecorderReport report_;
  std::size_t provided_for_ = 0, nodes_there_ = 0;
  WallTime nodes_there_since_{};
  bool has_samples_ = false;  // the recording under way, on the disk
  bool ends_ = false;
  WallTime failed_at_{};
  WallTime written_again_at_{};
  WallTime status_at_{};
  WallTime receipts_at_{};
  SessionController controller_;  // last: it may call back at once
};

}  // namespace roadbalance
