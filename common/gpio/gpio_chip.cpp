#include "common/gpio/gpio_chip.hpp"

#include <gpiod.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "common/gpio/device_place.hpp"

namespace roadbalance {
namespace {

constexpr const char* kChips = "/sys/bus/gpio/devices";

struct Closes {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, Closes>;

Chip open_chip(const std::string& name) {
  Chip chip(gpiod_chip_open_by_name(name.c_str()));
  if (!chip) throw GpioError("GPIO chip " + name + ": " + std::generic_category().message(errno));
  return chip;
}

/// Empty: it is gone.
std::string place_of(const std::string& chip) {
  std::error_code gone;
  const auto folder = std::filesystem::canonical(std::filesystem::path(kChips) / chip, gone);
  return gone ? "" : device_place(folder.parent_path());
}

/// All that are called so at that place.
std::vector<Chip> chips_like(const GpioChip::Identity& wanted) {
  std::vector<Chip> alike;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(kChips, none)) {
    const std::string name = entry.path().filename();
    if (place_of(name) != wanted.place) continue;
    Chip chip = open_chip(name);
    if (wanted.label == gpiod_chip_label(chip.get())) alike.push_back(std::move(chip));
  }
  return alike;
}

Chip find_again(const std::string& name, const GpioChip::Identity& before) {
  const std::string chip = "GPIO chip " + name + ": ", known = before.label + " at " + before.place;
  std::vector<Chip> alike = chips_like(before);
  if (alike.size() == 1 && before.is_the_only) return std::move(alike.front());
  if (!alike.empty()) throw GpioError(chip + "of several " + known + " it cannot be told which it was");
  const Chip other = open_chip(name);
  throw GpioError(chip + gpiod_chip_label(other.get()) + " at " + place_of(name) + " is called so now, not " +
                  known);
}

}  // namespace

struct GpioChip::State {
  std::string name;
  gpiod_chip* chip = nullptr;
  std::vector<gpiod_line*> lines;
  std::vector<pollfd> files;  ///< [line] readable while events wait

  // Closing a chip releases its lines.
  ~State() {
    if (chip) gpiod_chip_close(chip);
  }

  std::size_t take(unsigned offset, const std::string& consumer, int request, int flags) {
    const std::string what = "GPIO " + std::to_string(offset) + " of " + name;
    if (offset >= gpiod_chip_num_lines(chip))
      throw GpioError(what + ": no such line; allowed: 0 .. " +
                      std::to_string(gpiod_chip_num_lines(chip) - 1));
    gpiod_line* const line = gpiod_chip_get_line(chip, offset);
    if (!line) throw GpioError(what + ": " + std::generic_category().message(errno));
    const gpiod_line_request_config config{consumer.c_str(), request, flags};
    if (gpiod_line_request(line, &config, 0) != 0) {
      const int error = errno;
      throw GpioError(what + ": " +
                      (error == EBUSY ? user_of(line) : std::generic_category().message(error)));
    }
    lines.push_back(line);
    files.push_back({.fd = gpiod_line_event_get_fd(line), .events = POLLIN, .revents = 0});
    return lines.size() - 1;
  }

  static std::string user_of(gpiod_line* line) {
    const char* const user = gpiod_line_update(line) == 0 ? gpiod_line_consumer(line) : nullptr;
    return user ? "in use by \"" + std::string(user) + '"' : "in use by somebody who gives no name";
  }
};

GpioChip::GpioChip(const std::string& name, const Identity& before) : state_(std::make_unique<State>()) {
  state_->name = name;
  state_->chip = (before.label.empty() ? open_chip(name) : find_again(name, before)).release();
}

GpioChip::Identity GpioChip::identity() const {
  Identity identity{.label = gpiod_chip_label(state_->chip),
                    .place = place_of(gpiod_chip_name(state_->chip))};
  if (identity.place.empty()) return {};
  identity.is_the_only = chips_like(identity).size() == 1;
  return identity;
}

GpioChip::~GpioChip() = default;
GpioChip::GpioChip(GpioChip&&) noexcept = default;
GpioChip& GpioChip::operator=(GpioChip&&) noexcept = default;

std::size_t GpioChip::take_edges(unsigned offset, Edges edges, const std::string& consumer) {
  return state_->take(
      offset, consumer,
      edges == Edges::kRising ? GPIOD_LINE_REQUEST_EVENT_RISING_EDGE : GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES,
      0);
}

std::size_t GpioChip::take_level(unsigned offset, bool active_low, const std::string& consumer) {
  return state_->take(offset, consumer, GPIOD_LINE_REQUEST_DIRECTION_INPUT,
                      active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0);
}

void GpioChip::wait(std::chrono::milliseconds at_most, std::span<Waiting> lines) noexcept {
  auto& files = state_->files;
  assert(lines.size() <= files.size());
  ::poll(files.data(), lines.size(), static_cast<int>(at_most.count()));
  for (std::size_t k = 0; k < lines.size(); ++k)
    lines[k] = files[k].revents == 0        ? Waiting::kNothing
               : files[k].revents == POLLIN ? Waiting::kEvents
                                            : Waiting::kGone;
}

std::optional<std::size_t> GpioChip::read(std::size_t line, std::span<GpioEvent> events) noexcept {
  std::array<gpiod_line_event, kKernelEvents> raw;
  const int count = gpiod_line_event_read_fd_multiple(
      state_->files[line].fd, raw.data(), static_cast<unsigned>(std::min(events.size(), raw.size())));
  if (count < 0) return std::nullopt;
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
    events[k] = {raw[k].ts.tv_sec * std::int64_t{1'000'000'000} + raw[k].ts.tv_nsec,
                 raw[k].event_type == GPIOD_LINE_EVENT_RISING_EDGE};
  return static_cast<std::size_t>(count);
}

std::optional<bool> GpioChip::level(std::size_t line) noexcept {
  const int value = gpiod_line_get_value(state_->lines[line]);
  if (value < 0) return std::nullopt;
  return value > 0;
}

}  // namespace roadbalance
