#include "firmware/vehicle_change.hpp"

#include <algorithm>
#include <utility>

#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostAnswered = 16;

}  // namespace

VehicleChange::VehicleChange(std::string text, bool can_change)
    : text_(std::move(text)), crc32c_(crc32c(text_)), can_change_(can_change) {}

void VehicleChange::take(const VehiclePart& part) {
  if (part.vehicle_crc32c != arriving_ || part_.size() != static_cast<std::size_t>(part.parts)) {
    arriving_ = part.vehicle_crc32c;
    part_.assign(static_cast<std::size_t>(part.parts), {});
  }
  part_[static_cast<std::size_t>(part.part)] = part.text;
}

std::optional<std::string> VehicleChange::assembled(std::uint32_t crc32c) const {
  if (arriving_ != crc32c || part_.empty()) return std::nullopt;
  std::string text;
  for (const std::string& part : part_) {
    if (part.empty()) return std::nullopt;
    text += part;
  }
  if (roadbalance::crc32c(text) != crc32c) return std::nullopt;
  return text;
}

std::optional<VehicleChange::Outcome> VehicleChange::ask(const Command& command) {
  if (wanted_)
    return wanted_->request == command.request
               ? std::nullopt
               : std::optional(Outcome{CommandError::kMeasuring, "another change is being made"});
  if (command.vehicle_crc32c == crc32c_) return Outcome{};
  if (!can_change_)
    return Outcome{CommandError::kVehicleRefused, "this node was started with a vehicle.toml of its own"};
  auto text = assembled(command.vehicle_crc32c);
  if (!text) return Outcome{CommandError::kVehicleMissing, "parts of it have not arrived"};
  wanted_ = Wanted{.request = command.request, .text = std::move(*text)};
  return std::nullopt;
}

std::optional<VehicleChange::Outcome> VehicleChange::outcome(std::int64_t request) const {
  const auto answered = std::ranges::find(answered_, request, &AnsweredRequest::request);
  if (answered == answered_.end()) return std::nullopt;
  return answered->outcome;
}

void VehicleChange::made() {
  text_ = wanted_->text;
  crc32c_ = crc32c(text_);
  finish({});
}

void VehicleChange::refused(const std::string& why) {
  finish({CommandError::kVehicleRefused, why});
}

void VehicleChange::finish(Outcome outcome) {
  answered_.push_back({wanted_->request, std::move(outcome)});
  if (answered_.size() > kMostAnswered) answered_.pop_front();
  wanted_.reset();
  part_.clear();
  arriving_ = 0;
}

}  // namespace roadbalance
