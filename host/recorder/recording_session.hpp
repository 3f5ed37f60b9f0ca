#pragma once

#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// A recorder that runs beside who leads it: run_recorder() in a thread of its own.  Destroyed before it is
/// over it leaves the nodes as they are: they measure on and keep what is not on the disk for the next one.
class RecordingSession {
 public:
  /// What is known of it now.
  struct View {
    RecorderReport report;
    std::optional<RecorderStatus> status;  ///< the last that it has said
    bool is_over = false;
    std::string error;  ///< it is over and not all is on the disk
  };

  /// @param options  complete, notes and on_progress are replaced
  explicit RecordingSession(RecorderOptions options, std::function<void(RecorderStatus&)> complete);

  ~RecordingSession() { leave_.request_stop(); }

  void stop() { thread_.request_stop(); }
  void note(NoteToRecord note);
  View view() const;

 private:
  void run(std::stop_token stop);

  std::stop_source leave_;
  RecorderOptions options_;
  mutable std::mutex mutex_;
  std::vector<NoteToRecord> notes_;
  View view_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace roadbalance
