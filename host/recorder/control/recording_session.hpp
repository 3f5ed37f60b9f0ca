#pragma once

#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "host/recorder/control/session.hpp"

namespace roadbalance {

/// run_recorder() in a thread of its own.
class RecordingSession final : public Session {
 public:
  /// @param options  its `complete` is called from a thread of the recorder; notes, stopped_by and
  /// on_progress are replaced
  explicit RecordingSession(RecorderOptions options);
  ~RecordingSession() override { leave_.request_stop(); }

  void stop(const std::string& by) override;
  void note(NoteToRecord note) override;
  View view() const override;

 private:
  void run(std::stop_token stop);

  std::stop_source leave_;
  RecorderOptions options_;
  mutable std::mutex mutex_;
  std::vector<NoteToRecord> notes_;
  View view_;
  std::string stopped_by_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace roadbalance
