#include "host/analysis/balance/readings.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

constexpr double kUnlikely = 0.01;

/// Share of normal scatter that one standard deviation holds, 68.3 %, of a mean whose deviation is itself
/// taken from so many degrees of freedom: Student's quantile.  This is within 1 % from 2 on.
double student_factor(double freedom) {
  return 1.0 / (1.0 - 0.495 / freedom);
}

bool is_same_speed(double speed, double other) {
  return std::abs(other - speed) <= kSameSpeed * std::abs(speed);
}

/// The speed about which the runs are compared; nothing: no run has one.
std::optional<double> chosen_speed(const std::vector<Readings::Run>& runs, std::optional<double> wanted) {
  std::optional<double> best;
  std::ptrdiff_t most = 0;
  for (const Readings::Run& run : runs) {
    if (!run.speed) continue;
    if (wanted) {
      if (!best || std::abs(*run.speed - *wanted) < std::abs(*best - *wanted)) best = run.speed;
      continue;
    }
    const auto like = std::ranges::count_if(runs, [&](const Readings::Run& other) {
      return other.speed && is_same_speed(*run.speed, *other.speed);
    });
    if (like > most) {
      most = like;
      best = run.speed;
    }
  }
  return best;
}

/// Somebody may have written one run down with more digits: it does not count for more.
std::vector<InfluenceRun> influence_runs(const std::vector<const Readings::Run*>& runs) {
  std::vector<InfluenceRun> all;
  const auto by_digits = [&](std::size_t channel) {
    double largest = 0.0;
    for (const Readings::Run* const run : runs)
      largest = std::max(largest, run->reading[channel].digits_variance);
    return largest;
  };
  for (const Readings::Run* const run : runs) {
    const Eigen::Index channels = std::ssize(run->reading);
    InfluenceRun one{Eigen::Map<const Eigen::VectorXcd>(run->weight.data(), std::ssize(run->weight)),
                     Eigen::VectorXcd(channels), Eigen::VectorXd(channels)};
    for (Eigen::Index c = 0; c < channels; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      const Reading& reading = run->reading[channel];
      one.observed(c) = reading.vector;
      one.variance(c) = reading.sigma ? 2.0 * *reading.sigma * *reading.sigma : by_digits(channel);
    }
    all.push_back(std::move(one));
  }
  return all;
}

/// Raises variances that nobody stated to what the runs scatter about the fit.
/// @return whether any was
bool take_scatter(const std::vector<const Readings::Run*>& runs, const InfluenceBalance& fit, int beyond,
                  std::vector<InfluenceRun>& all) {
  bool any = false;
  const double factor = student_factor(2.0 * beyond);
  for (Eigen::Index c = 0; c < fit.bare.size(); ++c) {
    double square = 0.0;
    for (const InfluenceRun& run : all)
      square += std::norm(run.observed(c) - fit.bare(c) - (fit.influence.row(c) * run.weight).value());
    const double variance = factor * factor * square / beyond;
    for (std::size_t r = 0; r < all.size(); ++r) {
      if (runs[r]->reading[static_cast<std::size_t>(c)].sigma || variance <= all[r].variance(c)) continue;
      all[r].variance(c) = variance;
      any = true;
    }
  }
  return any;
}

std::vector<double> rms_without(const InfluenceBalance& found) {
  const Eigen::Index planes = found.influence.cols();
  std::vector<double> rms;
  if (planes < 2) return rms;
  for (Eigen::Index left_out = 0; left_out < planes; ++left_out) {
    Eigen::MatrixXcd others(found.influence.rows(), planes - 1);
    others << found.influence.leftCols(left_out), found.influence.rightCols(planes - 1 - left_out);
    const auto weights = correction_by_influence(others, found.bare);
    const Eigen::VectorXcd left = weights ? (found.bare + others * *weights).eval() : found.bare;
    rms.push_back(left.norm() / std::sqrt(static_cast<double>(left.size())));
  }
  return rms;
}

std::string lacks(const Readings& readings) {
  const std::size_t planes = readings.plane.size();
  return "these runs do not tell what a weight in " +
         (planes == 1 ? "the plane" : "each of the " + std::to_string(planes) + " planes") +
         " does: one without weights and one with a trial weight in each plane are needed, at the same "
         "speed, "
         "trial weights that change the readings by more than they scatter, and channels on which the planes "
         "act differently";
}

}  // namespace

ReadingsBalance balance_readings(const Readings& readings, std::optional<double> speed) {
  ReadingsBalance result;
  const auto about = chosen_speed(readings.run, speed);
  std::vector<const Readings::Run*> runs;
  double sum = 0.0;
  int known = 0;
  for (const Readings::Run& run : readings.run) {
    if (about && run.speed && !is_same_speed(*about, *run.speed)) {
      result.other_speed.push_back({run.name, *run.speed});
      continue;
    }
    runs.push_back(&run);
    result.used.push_back(run.name);
    sum += run.speed.value_or(0.0);
    known += run.speed ? 1 : 0;
  }
  if (known > 0) result.speed = sum / known;

  std::vector<InfluenceRun> all = influence_runs(runs);
  auto found = all.empty() ? std::nullopt : balance_by_influence(all);
  result.beyond = static_cast<int>(std::ssize(runs) - std::ssize(readings.plane) - 1);
  if (found && result.beyond > 0) {
    if (found->chance < kUnlikely && std::ranges::all_of(runs, [](const Readings::Run* run) {
          return std::ranges::all_of(run->reading, [](const Reading& one) { return one.sigma.has_value(); });
        }))
      result.remark.push_back(format(
          "the runs contradict one another by more than their sigmas allow (chance %.1g): a sigma is too "
          "small, a weight is elsewhere than written, or the rotor is not linear",
          found->chance));
    if (take_scatter(runs, *found, result.beyond, all)) found = balance_by_influence(all);
  }
  if (!found) {
    result.refusal = lacks(readings);
    return result;
  }
  const bool stated = std::ranges::any_of(runs, [](const Readings::Run* run) {
    return std::ranges::any_of(run->reading, [](const Reading& one) { return one.sigma.has_value(); });
  });
  if (result.beyond == 0 && !stated)
    result.remark.emplace_back(
        "no run was repeated and no sigma is stated: ± is what the digits of the readings leave open, the "
        "least that it can be");
  result.balance = *found;
  for (Eigen::Index p = 0; p < found->correction.size(); ++p)
    result.plane.push_back(plane_correction(found->correction(p), found->sigma(p)));
  result.rms_without = rms_without(*found);
  if (found->condition >= kAlikeFrom)
    result.remark.push_back(format(
        "ill-conditioned, condition number %.1f: the planes act nearly alike on what is read, so that an "
        "error of the readings may count up to so many times in the weights; read at another place or "
        "speed, too, or leave a plane out",
        found->condition));
  return result;
}

}  // namespace roadbalance
