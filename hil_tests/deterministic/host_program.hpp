#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hil_tests/deterministic/host_machine.hpp"

namespace roadbalance::test {

/// The product's two processes, receive and write, of one recording.
struct HostMachine::Program {
  Program(Disk& disk, const FaultScenario& scenario, const RecorderLinkOptions& options,
          const std::filesystem::path& folder, std::int64_t utc_us, std::int64_t host_ns,
          std::int64_t first_incarnation = 0);

  RecordingStore store;
  RecorderLink link;
  std::vector<RecordEvent> events;  // of clocks, for the writer
  std::size_t events_in_commit = 0;
  BatchMaker batches;
  std::deque<WriteBatch> waiting;  // for the writer
  std::int64_t waiting_blocks = 0;
  std::vector<DurableMark> marks;  // of the commit under way
  std::int64_t busy_until_ns = 0;  // the writer
  std::map<std::pair<std::int32_t, std::int64_t>, Ack> last_ack;
};

/// A session of the session controller: as RecordingSession, but turn by turn instead of in a thread.
class HostMachine::SteppedSession final : public Session {
 public:
  SteppedSession(HostMachine& host, const RecorderOptions& options);
  ~SteppedSession() override;

  void stop(const std::string&) override { stopping_ = true; }
  void note(NoteToRecord note) override { notes_.push_back(std::move(note)); }
  View view() const override;

  void take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  void turn(std::int64_t now_ns, const Publish& publish);

 private:
  void fail(const std::string& why);

  HostMachine& host_;
  const std::string recording_;
  std::unique_ptr<Program> program_;
  std::vector<NoteToRecord> notes_;
  bool stopping_ = false;
  bool has_run_ = false;
  RecorderReport report_;
  std::optional<RecorderStatus> status_;  // the last
  std::string error_;
};

}  // namespace roadbalance::test
