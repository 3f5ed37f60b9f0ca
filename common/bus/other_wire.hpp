#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace roadbalance {

/// Notices messages of another version of the wire, which every decoder refuses: without this a program of
/// another release would be passed over in silence.
///
/// A version is LCM's fingerprint of a message type.  A message is of another version if its channel is one
/// of ours, its fingerprint is of none of our types, and it is whole: it ends with its CRC, or, of types that
/// have none, its fingerprint has come on this channel before.  A pure state machine of bounded memory.
class OtherWire {
 public:
  void take(std::string_view channel, std::span<const std::uint8_t> bytes);

  /// For people, since the last call: once of each channel and fingerprint, with both fingerprints and what
  /// to do.
  std::vector<std::string> sentences() { return std::exchange(sentences_, {}); }

  /// Nodes that have spoken another version since the last call.
  std::set<std::int32_t> nodes() { return std::exchange(nodes_, {}); }

  static constexpr std::size_t kMostVersions = 64;  ///< that are distinguished

 private:
  std::map<std::pair<std::string, std::int64_t>, bool> reported_;  ///< by channel and fingerprint
  std::vector<std::string> sentences_;
  std::set<std::int32_t> nodes_;
};

}  // namespace roadbalance
