#pragma once

#include <optional>
#include <string>

#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// A recorder that runs beside the one that leads it.  Destroyed before it is over it leaves the nodes as
/// they are: they measure on and keep what is not on the disk for the next one.
class Session {
 public:
  /// Its state now.
  struct View {
    RecorderReport report;
    std::optional<RecorderStatus> status;  ///< the last that it has sent
    bool is_over = false;
    std::string error;  ///< it is over and not all is on the disk
  };

  virtual ~Session() = default;
  /// It stops the nodes, waits for their ends, and is over.
  /// @param by  who stops it, for the record
  virtual void stop(const std::string& by) = 0;
  virtual void note(NoteToRecord note) = 0;
  virtual View view() const = 0;
};

}  // namespace roadbalance
