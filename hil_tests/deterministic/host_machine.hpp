#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/publish.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/deterministic/asker.hpp"
#include "hil_tests/deterministic/clock_events.hpp"
#include "hil_tests/deterministic/fault_scenario.hpp"
#include "hil_tests/deterministic/random.hpp"
#include "hil_tests/deterministic/record_check.hpp"
#include "hil_tests/deterministic/truth.hpp"
#include "host/recorder/control/operating.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/recording_store.hpp"
#include "host/recorder/write_batch.hpp"

namespace roadbalance::test {

/// The computer with the recorder: the product's two processes, receive and write, on a disk, a clock and a
/// supply of the world's.
class HostMachine {
 public:
  HostMachine(const FaultScenario& scenario, int number, std::uint64_t seed, Truth& truth);
  ~HostMachine();

  /// Starts the recorder: it recovers its record first.  False if its disk does not let it start: again
  /// later.
  bool boot(std::int64_t now_ns);
  /// kill -9.
  void kill();
  /// The same, and what was not synced is gone or torn.
  void cut_power();
  /// One of the two in the middle of what the recorder does next with its disk: before system call `calls`,
  /// or before so many syncs, when most is under way.
  void die_at_call(bool power, int calls, bool only_syncs);
  bool is_up() const { return program_ || operating_; }
  bool runs() const { return is_up() && !paused_; }
  void pause(bool on) { paused_ = on; }
  void step_wall_clock(std::int64_t by_us) { utc_offset_us_ += by_us; }

  void take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// One turn of both processes; they may have died of it.
  void turn(std::int64_t now_ns, const Publish& publish);
  /// The drive is over: nodes are stopped, and the recorder ends when their ends are durable.
  void stop() { stopping_ = true; }
  /// A clock exchange or fit, to be recorded with what comes next.
  void record(RecordEvent event);
  /// It records now, or has something to fetch or to set up.
  bool has_work() const;
  /// CRC-32C of the vehicle.toml that it leads.
  std::uint32_t vehicle_crc32c();
  /// Behind check_record(): what was asked and answered against what it did.
  void check_asked(const std::vector<Asker::Asked>& asked);
  /// It has stopped as requested, and closed the record.
  bool closed() const { return closed_; }

  /// Space for little more than there is, and again for all.
  void fill_disk(bool full);
  /// Each call fails with this probability; 0: none.
  void fail_disk(double probability) { failing_ = probability; }
  /// Time of its disk since the last call.
  std::int64_t take_elapsed_ns();

  /// Holds what is finished of the record against the truth, so that it need not be kept.
  void check_finished();
  /// Holds the rest against it.  The recorder is gone.
  void check_record();
  RecordCheck& check() { return check_; }
  /// Behind check_record(): the nodes that were absent by its record, and whether it is called complete.
  std::vector<Absence> absences();
  bool is_called_complete();
  std::int64_t began_ns() const { return began_ns_; }  ///< its first start
  std::int64_t ns_of(std::int64_t utc_us) const;       ///< the instant, if its wall clock was never set
  const ClockEvents& clock_events() const { return clock_events_; }
  /// Its record goes on in the fallback folder.
  bool fell_back();
  /// Behind check_record(): the whole record, which rb recover made of both folders if there are two.
  const char* record_folder() { return fell_back() ? kWhole : kFolder; }
  SimulatedDisk& disk() { return disk_; }
  static constexpr const char* kFolder = "/record";
  static constexpr const char* kFallback = "/fallback";  ///< on another disk, which does not fail
  static constexpr const char* kWhole = "/whole";
  static constexpr const char* kRecordings = "/recordings";  ///< of an operated one, each a folder
  static constexpr const char* kVehicleOnDisk = "/vehicle/car.toml";

  double longest_to_durable_s() const { return longest_to_durable_s_; }
  int boots() const { return boots_; }
  /// How often it died while its disk failed or just after, so that its last answer may not be on it.
  int unsure_deaths() const { return unsure_deaths_; }
  /// How often it died before a call of its disk, not between two turns.
  int deaths_at_call() const { return deaths_at_call_; }
  int disk_fulls() const { return disk_fulls_; }  ///< times that it waited for space, by its record

 private:
  struct Program;
  class SteppedSession;
  friend class SteppedSession;
  bool say(Program& p, const std::string& channel, std::span<const std::uint8_t> bytes,
           const Publish& publish);
  void watch(Program& p, const Ack& ack);
  void watch(const WriteBatch& batch);
  void receive(Program& p, std::int64_t now_ns, const Publish& publish);
  void write(Program& p, std::int64_t now_ns);
  void became_durable(Program& p, const DurableMark& mark, std::int64_t now_ns);
  /// True: it has come to its end.
  bool end(Program& p, std::int64_t now_ns, const Publish& publish);
  bool boot_operating(std::int64_t now_ns);
  void turn_operating(std::int64_t now_ns, const Publish& publish);
  std::unique_ptr<Session> begin_session(const RecorderOptions& options);
  bool state_may_be_old() const;
  bool disk_may_fail() const;
  void check_begun(const RecorderOptions& options);
  void watch(const Answer& answer);
  void check_file(const Answer& done);
  void check_recordings();
  void take_notes(const std::string& recording, std::span<const std::uint8_t> bytes);
  void check_through(const char* folder, int last);
  void check_segments(const char* folder);
  void make_whole();
  std::int64_t utc_us(std::int64_t now_ns) const;
  SimulatedDisk::Outcome disk_call(DiskCall call, const std::string& path);
  std::chrono::nanoseconds disk_cost(DiskCall call, std::size_t bytes);

  const FaultScenario& scenario_;
  const int number_;
  Truth& truth_;
  Random random_;
  SimulatedDisk disk_;
  RecordCheck check_;
  ClockEvents clock_events_;
  std::unique_ptr<Program> program_;
  OperateOptions operate_;
  std::vector<SteppedSession*> sessions_;  // sessions of operating_
  std::unique_ptr<Operating> operating_;
  std::int64_t now_ns_ = 0;
  std::int64_t began_ns_ = 0;
  std::string checked_;                                                    // the folder of next_to_check_
  std::map<std::string, std::pair<std::int64_t, std::int64_t>> begun_by_;  // [recording] who asked
  struct FoundMark {
    std::string recording;
    std::int64_t number = 0;
  };
  std::map<std::string, FoundMark> marks_;  // [text]
  struct Word {
    AnswerState state = AnswerState::kUnderWay;
    int boots = 0, unsure_deaths = 0;  // until that answer
  };
  std::map<std::pair<std::int64_t, std::int64_t>, Word> reported_;  // [asker, request] the last word
  // Recordings that came to their end on a disk that failed: last words may be torn, which are no blocks.
  std::set<std::string> may_be_torn_;
  bool paused_ = false;
  bool stopping_ = false;
  bool closed_ = false;
  int calls_to_live_ = 0;  // 0: it lives
  bool dies_of_power_ = false;
  bool dies_at_sync_ = false;
  bool died_ = false;
  bool full_ = false;
  double failing_ = 0;
  int next_to_check_ = 1;  // segment
  std::set<int> deleted_;  // by retention, by the notes that were read
  int disk_fulls_ = 0;     // by these, too
  std::int64_t elapsed_seen_ns_ = 0;
  std::int64_t utc_offset_us_ = 0;
  int boots_ = 0;
  int deaths_at_call_ = 0;
  int unsure_deaths_ = 0;
  std::int64_t refused_at_ns_ = std::numeric_limits<std::int64_t>::min() / 2;  // a call of its disk
  std::map<std::pair<std::int32_t, std::int64_t>, std::int64_t> durable_;
  double longest_to_durable_s_ = 0;
};

}  // namespace roadbalance::test
