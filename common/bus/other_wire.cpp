#include "common/bus/other_wire.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <optional>
#include <system_error>
#include <wire/ack_t.hpp>
#include <wire/answer_t.hpp>
#include <wire/balance_t.hpp>
#include <wire/clock_fit_t.hpp>
#include <wire/command_t.hpp>
#include <wire/compensation_t.hpp>
#include <wire/edge_block_t.hpp>
#include <wire/end_t.hpp>
#include <wire/envelope_t.hpp>
#include <wire/gap_t.hpp>
#include <wire/heartbeat_t.hpp>
#include <wire/identification_t.hpp>
#include <wire/knock_t.hpp>
#include <wire/level_t.hpp>
#include <wire/meta_t.hpp>
#include <wire/orders_t.hpp>
#include <wire/receipt_t.hpp>
#include <wire/recorder_t.hpp>
#include <wire/recording_t.hpp>
#include <wire/remark_t.hpp>
#include <wire/reply_t.hpp>
#include <wire/request_t.hpp>
#include <wire/scan_block_t.hpp>
#include <wire/setup_t.hpp>
#include <wire/signal_block_t.hpp>
#include <wire/spectrum_t.hpp>
#include <wire/transfer_t.hpp>
#include <wire/vehicle_t.hpp>
#include <wire/verification_t.hpp>
#include <wire/view_t.hpp>
#include <wire/waterfall_t.hpp>

#include "common/bus/wire_format.hpp"

namespace roadbalance {
namespace {

enum class Speaker { kNode, kRecorder, kAnalyser, kViewer };

/// The message on channels "front" + number of a node + "back", or on "front" alone.
struct Kind {
  std::string_view front, back;
  std::int64_t fingerprint;
  Speaker speaker;
  bool of_a_node = true;
  bool has_crc = true;
};

const std::array<Kind, 32>& kinds() {
  static const std::array<Kind, 32> all{{
      {"RB_BLOCK_", "_SCAN", wire::scan_block_t::getHash(), Speaker::kNode},
      {"RB_BLOCK_", "_EDGE", wire::edge_block_t::getHash(), Speaker::kNode},
      {"RB_BLOCK_", "_GAP", wire::gap_t::getHash(), Speaker::kNode},
      {"RB_BLOCK_", "_META", wire::meta_t::getHash(), Speaker::kNode},
      {"RB_BLOCK_", "_END", wire::end_t::getHash(), Speaker::kNode},
      {"RB_BLOCK_", "_SIGNAL", wire::signal_block_t::getHash(), Speaker::kNode},
      {"RB_PREVIEW_", "", wire::scan_block_t::getHash(), Speaker::kNode},
      {"RB_HEARTBEAT_", "", wire::heartbeat_t::getHash(), Speaker::kNode},
      {"RB_REPLY_", "", wire::reply_t::getHash(), Speaker::kNode},
      {"RB_ACK_", "", wire::ack_t::getHash(), Speaker::kRecorder},
      {"RB_COMMAND_", "", wire::command_t::getHash(), Speaker::kRecorder},
      {"RB_CLOCK_", "", wire::clock_fit_t::getHash(), Speaker::kRecorder},
      {"RB_VEHICLE_", "", wire::vehicle_t::getHash(), Speaker::kRecorder},
      {"RB_REQUEST", "", wire::request_t::getHash(), Speaker::kViewer, false},
      {"RB_ANSWER", "", wire::answer_t::getHash(), Speaker::kRecorder, false},
      {"RB_RECEIPT", "", wire::receipt_t::getHash(), Speaker::kRecorder, false},
      {"RB_RECORDER", "", wire::recorder_t::getHash(), Speaker::kRecorder, false},
      {"RB_LEVEL", "", wire::level_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_SPECTRUM", "", wire::spectrum_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_ORDERS", "", wire::orders_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_IDENTIFICATION", "", wire::identification_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_BALANCE", "", wire::balance_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_TRANSFER", "", wire::transfer_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_VIEW", "", wire::view_t::getHash(), Speaker::kViewer, false, false},
      {"RB_ENVELOPE", "", wire::envelope_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_WATERFALL", "", wire::waterfall_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_COMPENSATION", "", wire::compensation_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_REMARK", "", wire::remark_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_KNOCK", "", wire::knock_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_VERIFICATION", "", wire::verification_t::getHash(), Speaker::kAnalyser, false, false},
      {"RB_SETUP_", "", wire::setup_t::getHash(), Speaker::kNode, true, false},
      {"RB_RECORDING", "", wire::recording_t::getHash(), Speaker::kRecorder, false, false},
  }};
  return all;
}

bool is_of(std::string_view channel, const Kind& kind) {
  if (!kind.of_a_node) return channel == kind.front;
  if (!channel.starts_with(kind.front) || !channel.ends_with(kind.back)) return false;
  if (channel.size() <= kind.front.size() + kind.back.size()) return false;
  channel.remove_prefix(kind.front.size());
  channel.remove_suffix(kind.back.size());
  return std::all_of(channel.begin(), channel.end(), [](char c) { return '0' <= c && c <= '9'; });
}

const Kind* kind_of(std::string_view channel) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [channel](const Kind& kind) { return is_of(channel, kind); });
  return found == kinds().end() ? nullptr : &*found;
}

std::string_view digits_of(std::string_view channel, const Kind& kind) {
  return channel.substr(kind.front.size(), channel.size() - kind.front.size() - kind.back.size());
}

/// That speaks; 0: it is none.
std::int32_t speaking_node(std::string_view channel, const Kind& kind) {
  std::int32_t node = 0;
  if (kind.speaker != Speaker::kNode) return 0;
  const auto digits = digits_of(channel, kind);
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), node);
  return read.ec == std::errc() ? node : 0;
}

std::string node_of(std::string_view channel, const Kind& kind) {
  const auto digits = digits_of(channel, kind);
  return digits == "0" ? "a recorder" : "node " + std::string(digits);  // 0: the host's own blocks
}

std::string hexadecimal(std::int64_t fingerprint) {
  char text[24];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(fingerprint));
  return text;
}

std::string sentence(std::string_view channel, const Kind& kind, std::int64_t theirs) {
  std::string who = "an analyser";
  if (kind.speaker == Speaker::kViewer) who = "a viewer";
  if (kind.speaker == Speaker::kNode) who = node_of(channel, kind);
  if (kind.speaker == Speaker::kRecorder)
    who = "a recorder" + (kind.of_a_node ? " that speaks to " + node_of(channel, kind) : std::string());
  return who + " is of another version of the wire (" + std::string(channel) + ": " + hexadecimal(theirs) +
         ", here " + hexadecimal(kind.fingerprint) +
         "): what it says there is ignored; install the same release of roadbalance on every computer of "
         "this "
         "bus";
}

}  // namespace

void OtherWire::take(std::string_view channel, std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 8) return;
  const std::int64_t theirs = wire_format::load_i64(bytes.data());
  const bool is_ours = std::any_of(kinds().begin(), kinds().end(),
                                   [theirs](const Kind& kind) { return kind.fingerprint == theirs; });
  if (is_ours) return;
  const Kind* kind = kind_of(channel);
  if (!kind || (kind->has_crc && !ends_with_its_crc(bytes))) return;
  const std::pair key(std::string(channel), theirs);
  const auto known = reported_.find(key);
  if (known == reported_.end()) {
    if (reported_.size() >= kMostVersions) return;
    reported_[key] = kind->has_crc;
    if (kind->has_crc) sentences_.push_back(sentence(channel, *kind, theirs));
  } else if (!std::exchange(known->second, true)) {
    sentences_.push_back(sentence(channel, *kind, theirs));
  }
  if (const std::int32_t node = speaking_node(channel, *kind); node > 0 && reported_.at(key))
    nodes_.insert(node);
}

}  // namespace roadbalance
