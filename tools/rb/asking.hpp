#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/recorder_status.hpp"

namespace roadbalance {

/// Whom requests of this program name: "rb of anna at laptop".
std::string who_asks();

/// Asks the recorder on a bus for something, and repeats it until it is answered for good.
class Asking {
 public:
  /// @throws std::runtime_error naming the URL
  explicit Asking(const std::string& url);

  /// @param request  its asker and number are set here
  /// @param silent   called once if there is no answer for three seconds
  /// @return the last answer, of whatever state; nothing: there was none
  std::optional<Answer> ask(Request request, std::chrono::milliseconds patience,
                            const std::function<void()>& silent = {});

  /// The receipts of the recording that was stopped last, by node; waits for all of them.
  const std::map<std::int32_t, Receipt>& receipts(std::chrono::milliseconds patience);

  /// Why there is no answer, and the remedy.
  std::string silence() const;

 private:
  Bus bus_;
  Request request_;
  std::optional<Answer> answer_;
  std::map<std::int32_t, Receipt> receipts_;  // by place
  std::optional<RecorderStatus> recorder_;
};

/// The receipts of every node are there, of one at least, and prove that each sample is on the disk.
bool are_whole(const std::map<std::int32_t, Receipt>& receipts);

/// "not while a recording is under way".
const char* text_of(RefusalReason reason);

}  // namespace roadbalance
