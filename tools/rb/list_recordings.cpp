#include "tools/rb/list_recordings.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "common/clock/utc.hpp"
#include "common/text/printable.hpp"
#include "host/receipts/receipt.hpp"
#include "host/receipts/recordings_list.hpp"
#include "tools/rb/progress_line.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kStates{"not read", "being recorded", "complete", "incomplete", "damaged", "unreadable"};

const char* state_of(const RecordingReceipt& receipt) {
  return kStates[static_cast<std::size_t>(receipt.state)];
}

bool is_read(const RecordingReceipt& receipt) {
  return receipt.state != RecordingState::kNotRead && receipt.state != RecordingState::kGrowing;
}

double seconds_of(const RecordingReceipt& receipt) {
  double seconds = 0.0;
  for (const auto& node : receipt.node) seconds = std::max(seconds, node.seconds);
  return seconds;
}

}  // namespace

std::vector<RecordingReceipt> recordings_in(const std::filesystem::path& folder) {
  RecordingsList list(folder);
  list.look(RecordingsList::FileTime::clock::now());
  std::int64_t all = 0, read = 0;
  for (const ListedRecording& one : list.listed()) all += one.receipt.bytes;
  ProgressLine line;
  while (const auto next = list.unread_one()) {
    const RecordingReceipt receipt = receipt_of(*next);
    read += receipt.bytes;
    list.take(receipt);
    line.show(all > 0 ? static_cast<double>(read) / static_cast<double>(all) : 1.0,
              static_cast<std::uint64_t>(read));
  }
  std::vector<RecordingReceipt> found;
  for (const ListedRecording& one : list.listed()) found.push_back(one.receipt);
  return found;
}

Json recordings_json(const std::vector<RecordingReceipt>& recordings) {
  Json all = Json::array();
  for (const RecordingReceipt& receipt : recordings) {
    Json one{{"name", receipt.name}, {"bytes", receipt.bytes}, {"state", state_of(receipt)}};
    if (is_read(receipt)) {
      Json nodes = Json::array();
      for (const auto& node : receipt.node)
        nodes.push_back(
            {{"node", node.node}, {"samples", node.samples}, {"samples_lost", node.samples_lost}});
      one.update({{"vehicle", receipt.vehicle},
                  {"begins", receipt.first_us > 0 ? Json(utc_text(receipt.first_us)) : Json()},
                  {"seconds", seconds_of(receipt)},
                  {"rate_hz", receipt.rate_hz},
                  {"marks", receipt.marks},
                  {"nodes", nodes},
                  {"verdict", receipt.verdict}});
    }
    all.push_back(one);
  }
  return {{"recordings", all}};
}

void print_recordings(const std::vector<RecordingReceipt>& recordings) {
  for (const RecordingReceipt& receipt : recordings) {
    std::printf("%-32s %9.1f MB  %-14s", printable_text(receipt.name).c_str(),
                1e-6 * static_cast<double>(receipt.bytes), state_of(receipt));
    if (is_read(receipt))
      std::printf("  %s  %8.1f s  %zu nodes, %d marks  %s",
                  receipt.first_us > 0 ? utc_text(receipt.first_us).c_str() : "at a time not known",
                  seconds_of(receipt), receipt.node.size(), receipt.marks,
                  printable_text(receipt.vehicle).c_str());
    std::printf("\n");
  }
}

}  // namespace roadbalance
