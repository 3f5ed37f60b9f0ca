#include "host/recorder/control/recording_session.hpp"

#include <exception>
#include <utility>

namespace roadbalance {

RecordingSession::RecordingSession(RecorderOptions options) : options_(std::move(options)) {
  options_.complete = [this, complete = std::move(options_.complete)](RecorderStatus& status) {
    if (complete) complete(status);
    const std::lock_guard lock(mutex_);
    view_.status = status;
  };
  options_.leave = leave_.get_token();
  options_.notes = [this] {
    const std::lock_guard lock(mutex_);
    return std::exchange(notes_, {});
  };
  options_.stopped_by = [this] {
    const std::lock_guard lock(mutex_);
    return stopped_by_;
  };
  options_.on_progress = [this](const RecorderReport& report) {
    const std::lock_guard lock(mutex_);
    view_.report = report;
  };
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

void RecordingSession::stop(const std::string& by) {
  {
    const std::lock_guard lock(mutex_);
    if (stopped_by_.empty()) stopped_by_ = by;
  }
  thread_.request_stop();
}

void RecordingSession::note(NoteToRecord note) {
  const std::lock_guard lock(mutex_);
  notes_.push_back(std::move(note));
}

RecordingSession::View RecordingSession::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

void RecordingSession::run(std::stop_token stop) {
  RecorderReport report;
  std::string error;
  try {
    report = run_recorder(stop, options_);
  } catch (const std::exception& failure) {
    error = failure.what();
    if (error.empty()) error = "unknown error";
  }
  const std::lock_guard lock(mutex_);
  if (error.empty()) view_.report = report;
  view_.error = error;
  view_.is_over = true;
}

}  // namespace roadbalance
