#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/bus.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// A loop of numbered messages of the size of a block over LCM, a millisecond apart: to this computer itself,
/// and to every other on which `rb doctor --answer` runs.
class BusLoop {
 public:
  /// The messages that came back, from this program itself or from one that answers.
  struct Way {
    std::string name = {};                ///< of the computer that answered
    std::set<std::int32_t> numbers = {};  ///< of the messages that came; one that came twice came once
    std::int64_t late = 0;                ///< so many behind one that was sent after them
    std::vector<double> back_ms = {};     ///< from sending to hearing, of each
    std::int64_t came() const { return std::ssize(numbers); }
    /// Quantile of all that came; 0 if none did.  @param share  0 to 1
    double within_ms(double share) const;
  };

  /// @throws std::runtime_error if LCM does not start
  explicit BusLoop(const std::string& url);

  /// @param pause  how long is listened after the last
  void run(int messages, std::chrono::milliseconds pause = std::chrono::milliseconds(300));

  std::int64_t sent() const { return sent_; }
  const Way& own() const { return own_; }
  /// By a number that each program that answers has drawn: computers may have one name.
  const std::map<std::int32_t, Way>& answers() const { return answers_; }
  /// Bytes that the kernel gives the socket that hears them.
  std::int64_t receive_buffer() const { return receiver_.receive_buffer(); }

 private:
  void take(std::span<const std::uint8_t> bytes);

  const std::int64_t run_;
  Bus sender_, receiver_;
  std::vector<std::chrono::steady_clock::time_point> sent_at_ = {};
  std::int64_t sent_ = 0;
  Way own_;
  std::map<std::int32_t, Way> answers_ = {};
};

/// Answers to every loop on this bus until `stop` is requested.
/// @returns how many messages were answered; @throws as BusLoop
std::int64_t answer_loops(const std::string& url, const std::stop_token& stop);

/// Findings of a loop: the way to this computer itself and to each that answered.
/// @param url  of the bus on which others were to answer; empty: the loop had a bus of its own
std::vector<Finding> loop_findings(const BusLoop& loop, const std::string& url);

}  // namespace roadbalance
