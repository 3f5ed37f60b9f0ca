#include "hil_tests/guest/ring_program.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roadbalance::test {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr double kToothAfterMark = 0.3;  // of a pitch

}  // namespace

void add_pulse(std::vector<gpio_pulse_step>& steps, unsigned line, std::int64_t begin_ns,
               std::int64_t period_ns) {
  steps.push_back({static_cast<std::uint64_t>(begin_ns), line, 1});
  steps.push_back({static_cast<std::uint64_t>(begin_ns + period_ns / 2), line, 0});
}

std::vector<gpio_pulse_step> pulses(unsigned line, std::int64_t begin_ns, std::int64_t period_ns, int count) {
  std::vector<gpio_pulse_step> steps;
  for (int k = 0; k < count; ++k) add_pulse(steps, line, begin_ns + k * period_ns, period_ns);
  return steps;
}

std::vector<gpio_pulse_step> in_order(std::vector<gpio_pulse_step> steps) {
  std::ranges::stable_sort(steps, {}, &gpio_pulse_step::t_ns);
  return steps;
}

void RingProgram::add_to(std::vector<gpio_pulse_step>& steps) const {
  const auto pitch_ns = std::llround(1e9 / turns_hz / teeth);
  for (int n = 0; n < turns * teeth; ++n)
    add_pulse(steps, tooth, time_ns((n + kToothAfterMark) / teeth), pitch_ns);
  for (int turn = 0; turn < turns; ++turn) add_pulse(steps, mark, time_ns(turn), pitch_ns);
}

double RingProgram::turns_at(std::int64_t monotonic_ns) const {
  return static_cast<double>(monotonic_ns - begin_ns) * 1e-9 * turns_hz;
}

std::int64_t RingProgram::time_ns(double after_turns) const {
  return begin_ns + std::llround(after_turns / turns_hz * 1e9);
}

PlayedLate::PlayedLate(const std::vector<gpio_pulse_step>& asked,
                       const std::vector<gpio_pulse_step>& played) {
  if (asked.empty() || asked.size() != played.size())
    throw std::runtime_error("played " + std::to_string(played.size()) + " levels of " +
                             std::to_string(asked.size()));
  begin_ms_ = static_cast<std::int64_t>(asked.front().t_ns) / kMillisecond_ns;
  for (std::size_t k = 0; k < asked.size(); ++k) {
    const auto millisecond =
        static_cast<std::size_t>(static_cast<std::int64_t>(asked[k].t_ns) / kMillisecond_ns - begin_ms_);
    if (late_ns_.size() <= millisecond) late_ns_.resize(millisecond + 1);
    late_ns_[millisecond] =
        std::max(late_ns_[millisecond], static_cast<std::int64_t>(played[k].t_ns - asked[k].t_ns));
  }
}

std::int64_t PlayedLate::most_ns(std::int64_t from_ns, std::int64_t to_ns) const {
  const auto index = [&](std::int64_t time_ns) {
    return std::clamp<std::int64_t>(time_ns / kMillisecond_ns - begin_ms_, 0,
                                    static_cast<std::int64_t>(late_ns_.size()));
  };
  const auto begin = late_ns_.begin() + index(from_ns),
             end = late_ns_.begin() + index(to_ns + kMillisecond_ns);
  return begin < end ? *std::max_element(begin, end) : 0;
}

std::int64_t PlayedLate::most_ns() const {
  return *std::ranges::max_element(late_ns_);
}

}  // namespace roadbalance::test
