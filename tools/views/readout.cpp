#include "tools/views/readout.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/bus/channel_faults.hpp"
#include "common/text/format.hpp"
#include "host/analysis/balance/weight_plan.hpp"
#include "tools/views/alarm_lines.hpp"

namespace roadbalance {
namespace {

/// Whole degrees 0 .. 359; the sum with 0 takes the sign from a zero.
double whole_degrees(double angle_rad) {
  return std::fmod(std::round(angle_rad * 180.0 / std::numbers::pi), 360.0) + 0.0;
}

std::string wheel_name(std::int32_t wheel) {
  std::string name = wheel >= 0 && wheel < kWheels ? kWheelNames[static_cast<std::size_t>(wheel)] : "?";
  std::replace(name.begin(), name.end(), '_', ' ');
  name += ':';
  name.resize(12, ' ');
  return name;
}

}  // namespace

std::string reason(Unknown state) {
  switch (state) {
    case Unknown::kNone:
      return "known";
    case Unknown::kTooShort:
      return "not enough driving at a steady speed yet";
    case Unknown::kTooSlow:
      return "the car never went fast enough";
    case Unknown::kNoReference:
      return "this wheel has no angle";
    case Unknown::kIllConditioned:
      return "the drive does not determine it";
    case Unknown::kUnfitVehicle:
      return "this vehicle's sensors or rates do not allow it";
    case Unknown::kNoCommonTime:
      return "the nodes' samples do not lie on one grid of time";
    case Unknown::kInStep:
      return "it turns in step with another wheel: take a bend or change lanes";
  }
  return "unknown reason";
}

std::string balance_line(const Balance& balance) {
  const std::string name = wheel_name(balance.wheel);
  if (balance.state != Unknown::kNone) return name + " not known: " + reason(balance.state);
  return name + format(" heavy spot %3.0f°, %4.1f g, ± %.1f g ± %.0f°", whole_degrees(balance.angle_rad),
                       balance.unbalance_g, shown_sigma(balance.sigma_g, 0.1),
                       std::min(180.0, std::ceil(balance.sigma_rad * 180.0 / std::numbers::pi)));
}

std::vector<std::string> step_words(const Compensation& compensation) {
  std::vector<std::string> steps;
  switch (compensation.advice) {
    case Advice::kUnknown:
      break;
    case Advice::kSteps:
      for (const WeightStep& step : compensation.plan.step)
        steps.push_back(to_string(step, compensation.radii));
      break;
    case Advice::kLeaveUncertain:
      steps.emplace_back("leave it: the unbalance is within its own uncertainty");
      break;
    case Advice::kLeaveSmall:
      steps.emplace_back("leave it: no weight there is makes it enough less");
      break;
  }
  return steps;
}

std::string left_words(const Balance& balance, const Compensation& compensation) {
  const BalanceVerdict& verdict = compensation.verdict;
  std::string left = format("leaves %.1f g, %s what a shop leaves (%g g)", verdict.residual_g,
                            verdict.within_shop() ? "within" : "MORE THAN", verdict.shop_g);
  if (verdict.permissible_g > 0.0)
    left += format(", ISO G %.2g%s G %g (%.0f g%s)", verdict.grade_mm_s,
                   verdict.within_iso() ? " within" : " BEYOND", verdict.permissible_grade_mm_s,
                   verdict.permissible_g, verdict.by_rotor ? "" : " by the unsprung mass");
  return left +
         format("; at %.0f–%.0f km/h", 3.6 * balance.least_speed_m_s, 3.6 * balance.greatest_speed_m_s);
}

std::vector<std::string> advice_lines(const Balance& balance, const Compensation& compensation) {
  if (compensation.advice == Advice::kUnknown) return {};
  std::string what = "  ";
  for (const std::string& step : step_words(compensation)) what += (what == "  " ? "" : ", ") + step;
  std::vector<std::string> lines{what, "  " + left_words(balance, compensation)};
  if (!compensation.verdict.incurable.empty())
    lines.push_back("  WEIGHTS WILL NOT CURE THIS: " + compensation.verdict.incurable);
  return lines;
}

std::string identification_line(const Identification& identification, const std::string& missing) {
  if (identification.state == Unknown::kTooShort && identification.sections > 0)
    return format("suspension: not known: %.0f s of steady driving so far, %.0f needed",
                  identification.seconds_used, identification.seconds_needed);
  if (identification.state != Unknown::kNone)
    return "suspension: not known: " + reason(identification.state) +
           (identification.state == Unknown::kIllConditioned && !missing.empty() ? ": " + missing : "");
  std::string line = format("from %.0f s of driving; tyres", identification.seconds_used);
  for (std::size_t w = 0; w < kWheels; ++w)
    line += format(" %.0f ± %.0f", identification.tyre_n_m[w] / 1e3,
                   shown_sigma(identification.sigma_tyre_n_m[w] / 1e3, 1.0));
  return line + " kN/m";
}

double shown_sigma(double sigma, double last_digit) {
  return sigma < last_digit ? last_digit : sigma;
}

std::vector<std::string> suspension_lines(const Identification& identification) {
  if (identification.state != Unknown::kNone) return {};
  const auto values = [](const char* name, const auto& value, const auto& sigma, double unit, int digits,
                         const char* unit_name) {
    std::string text = name;
    for (std::size_t i = 0; i < value.size(); ++i)
      text += format(" %.*f ± %.*f", digits, value[i] / unit, digits,
                     shown_sigma(sigma[i] / unit, std::pow(10.0, -digits)));
    return text + " " + unit_name;
  };
  return {
      values("springs", identification.spring_n_m, identification.sigma_spring_n_m, 1e3, 1, "kN/m") + "; " +
          values("dampers", identification.damper_n_s_m, identification.sigma_damper_n_s_m, 1.0, 0, "N s/m"),
      values("stabilisers", identification.stabiliser_n_m, identification.sigma_stabiliser_n_m, 1e3, 1,
             "kN/m")};
}

std::string node_line(const Heartbeat& heartbeat, std::optional<double> memory_left_s) {
  const double part_full = heartbeat.ring_capacity > 0 ? static_cast<double>(heartbeat.ring_used) /
                                                             static_cast<double>(heartbeat.ring_capacity)
                                                       : 0.0;
  std::string line = format(
      "node %d: %lld samples taken, %lld missing, %lld blocks repaired, memory %.0f %% full", heartbeat.node,
      static_cast<long long>(heartbeat.scans_sampled), static_cast<long long>(heartbeat.scans_missing),
      static_cast<long long>(heartbeat.blocks_repaired), 100.0 * part_full);
  if (memory_left_s) line += format(", lasts %.0f s", *memory_left_s);
  if (heartbeat.spool_used > 0)
    line += format(", %lld blocks on its disk", static_cast<long long>(heartbeat.spool_used));
  if (heartbeat.spool_failures > 0)
    line += format(", ITS DISK REFUSED %lld times", static_cast<long long>(heartbeat.spool_failures));
  if (heartbeat.owner > 0)
    line += format(", obeys recorder %lld", static_cast<long long>(heartbeat.owner));
  else
    line += ", obeys no recorder";
  return line;
}

std::string device_line(const Heartbeat& heartbeat) {
  std::string line;
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    if (const std::int64_t count = heartbeat.device_counts[k]; count != 0)
      line += (line.empty() ? "devices: " : ", ") + std::string(name_of(static_cast<DeviceCounter>(k))) +
              " " + std::to_string(count);
  return line;
}

std::vector<std::string> level_lines(const Level& level) {
  std::vector<std::string> lines{
      format(
          "node %d: %s", level.node,
          std::isfinite(level.speed_m_s) ? format("%.1f km/h", level.speed_m_s * 3.6).c_str() : "no speed") +
      (level.skipped > 0
           ? format(", the live view skipped %lld blocks", static_cast<long long>(level.skipped))
           : "")};
  for (unsigned c = 0; c < kAccelerations; ++c) {
    // A bar of 20 characters over four decades from 1 mm/s^2.
    const double decades = std::log10(std::max(level.rms[c], 1e-3) / 1e-3);
    const auto bar = static_cast<std::size_t>(std::clamp(decades * 5.0, 0.0, 20.0));
    std::string marks = level.overload >> c & 1U ? " OVERLOAD" : "";
    if (is_clipped(level, c)) marks += " CLIPPED";
    if (is_dead(level, c)) marks += " DEAD";
    if (is_railed(level, c)) marks += format(" DC OFFSET %+.1f m/s²", level.mean[c]);
    lines.push_back(format("  %2u  rms %8.3f  peak %8.3f m/s²  ", c + 1, level.rms[c], level.peak[c]) +
                    std::string(bar, '#') + marks);
  }
  return lines;
}

Screen::Screen() : terminal_(isatty(STDOUT_FILENO) == 1) {}

void Screen::draw(const std::vector<std::string>& lines, bool news) {
  if (!terminal_) {
    if (news) log(lines);
    return;
  }
  // Only text that fits can be rewritten in place: the last lines are left out, long ones are cut.
  std::size_t shown = lines.size();
  winsize window{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_row > 1)
    shown = std::min<std::size_t>(shown, window.ws_row - 1U);
  if (drawn_ > 0) std::printf("\033[%zuA\033[J", drawn_);
  std::printf("\033[?7l");
  for (std::size_t i = 0; i < shown; ++i) std::printf("%s\n", coloured(lines[i]).c_str());
  std::printf("\033[?7h");
  std::fflush(stdout);
  drawn_ = shown;
}

void Screen::log(const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (i >= logged_.size() || lines[i] != logged_[i]) std::printf("%s\n", lines[i].c_str());
  std::fflush(stdout);
  logged_ = lines;
}

}  // namespace roadbalance
