#include "host/analysis/orders/rotor_balance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "common/types/angle_units.hpp"
#include "host/analysis/balance/four_run.hpp"
#include "host/analysis/balance/influence.hpp"

namespace roadbalance {
namespace {

struct Observed {
  std::complex<double> vector;
  double variance;
  double from_m_s, to_m_s;
};
/// By node, channel and class of speed.
using Key = std::pair<std::string, long>;
using Observations = std::map<Key, Observed>;

Observations observations_of(const WeightedRun& run) {
  Observations all;
  for (const RotorOrders* const orders : run.orders)
    for (std::size_t c = 0; c < orders->channel().size(); ++c)
      for (const auto& speed : orders->vectors().result(static_cast<int>(c), 0).by_speed) {
        const auto confidence = speed.vector.confidence();
        const double variance = confidence ? confidence->covariance.trace() : 0.0;
        if (!(variance > 0.0)) continue;
        const std::string name =
            orders->node().name + "." + orders->node().channel[orders->channel()[c]].name;
        all[{name, std::lround(1e3 * speed.from_hz)}] = {
            speed.vector.mean(), variance, speed.from_hz * orders->way_m(), speed.to_hz * orders->way_m()};
      }
  return all;
}

/// The observations that every run has, for each run.
std::vector<Observations> common_observations(const std::vector<WeightedRun>& runs) {
  std::vector<Observations> all;
  for (const WeightedRun& run : runs) all.push_back(observations_of(run));
  for (Observations& one : all)
    std::erase_if(one, [&](const auto& entry) {
      return std::ranges::any_of(all,
                                 [&](const Observations& other) { return !other.contains(entry.first); });
    });
  return all;
}

RotorBalance by_influence(const RotorConfig& rotor, const std::vector<WeightedRun>& runs,
                          const std::vector<Observations>& observed) {
  RotorBalance result;
  std::vector<InfluenceRun> all;
  const Eigen::Index planes = std::ssize(rotor.plane), count = std::ssize(observed.front());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    InfluenceRun one{Eigen::VectorXcd(planes), Eigen::VectorXcd(count), Eigen::VectorXd(count),
                     runs[r].phase_sigma_rad};
    // An angle that is counted with more datum shows every phase behind by as much.
    const auto to_first = std::polar(1.0, runs[r].datum_rad - runs.front().datum_rad);
    for (Eigen::Index p = 0; p < planes; ++p) one.weight(p) = runs[r].weight_g[static_cast<std::size_t>(p)];
    Eigen::Index at = 0;
    for (const auto& [key, value] : observed[r]) {
      one.observed(at) = value.vector * to_first;
      one.variance(at++) = value.variance;
    }
    all.push_back(std::move(one));
  }
  const auto balance = balance_by_influence(all);
  if (!balance) {
    result.refusal =
        "these drives do not tell what a weight in each of the " + std::to_string(planes) +
        " planes does: one without weights and one with a trial weight in each plane are needed, and "
        "channels on which the planes act differently";
    return result;
  }
  for (Eigen::Index p = 0; p < planes; ++p)
    result.plane.push_back(plane_correction(balance->correction(p), balance->sigma(p)));
  result.observations = static_cast<int>(count);
  result.rms_before = balance->rms_before;
  result.rms_after = balance->rms_after;
  result.condition = balance->condition;
  return result;
}

/// Places of the bare run, and of the others if they have the same weight in the same one plane.
struct FourRuns {
  std::size_t bare = 0, plane = 0;
  double mass_g = 0.0;
};
std::optional<FourRuns> four_runs(const std::vector<WeightedRun>& runs) {
  FourRuns found;
  int bare = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const auto& weight = runs[r].weight_g;
    const auto loaded = std::ranges::count_if(weight, [](auto w) { return std::abs(w) > 0.0; });
    if (loaded > 1) return std::nullopt;
    if (loaded == 0) {
      ++bare;
      found.bare = r;
      continue;
    }
    const auto at = std::ranges::max_element(weight, {}, [](auto w) { return std::abs(w); });
    const auto plane = static_cast<std::size_t>(at - weight.begin());
    if (found.mass_g > 0.0 &&
        (plane != found.plane || std::abs(std::abs(*at) - found.mass_g) > 1e-6 * found.mass_g))
      return std::nullopt;
    found.plane = plane;
    found.mass_g = std::abs(*at);
  }
  if (bare != 1 || runs.size() < 4) return std::nullopt;
  return found;
}

const char* const kFourRuns =
    "without phase weights are found in one plane at a time, from one drive without weights and three or "
    "more with the same trial weight at different angles of that plane";

/// Number of angles of the trial weight, a degree apart at least.
int different_angles(const std::vector<WeightedRun>& runs, const FourRuns& wanted) {
  constexpr double kApart_rad = kTurn / 360.0;
  std::vector<double> angles;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const double angle = std::arg(runs[r].weight_g[wanted.plane]);
    const auto is_near = [&](double other) {
      return std::abs(std::remainder(angle - other, kTurn)) < kApart_rad;
    };
    if (r != wanted.bare && std::ranges::none_of(angles, is_near)) angles.push_back(angle);
  }
  return static_cast<int>(angles.size());
}

std::string text_of(const Key& key, const Observed& observed) {
  char speed[60];
  std::snprintf(speed, sizeof speed, " at %.1f .. %.1f m/s", observed.from_m_s, observed.to_m_s);
  return key.first + speed;
}

RotorBalance by_amplitude(const RotorConfig& rotor, const std::vector<WeightedRun>& runs,
                          const std::vector<Observations>& observed) {
  RotorBalance result{.refusal =
                          "the rotor's angle is not the same in two drives, so their phases cannot be "
                          "compared; " +
                          std::string(kFourRuns),
                      .by_amplitude = true,
                      .plane = {}};
  const auto wanted = four_runs(runs);
  if (!wanted) return result;
  if (const int angles = different_angles(runs, *wanted); angles < 3) {
    result.refusal = "the trial weight was at " + std::to_string(angles) +
                     (angles == 1 ? " angle" : " different angles") + " of its plane only; " + kFourRuns;
    return result;
  }
  std::optional<FourRunBalance> best;
  for (const auto& [key, bare] : observed[wanted->bare]) {
    std::vector<AmplitudeRun> trials;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (r == wanted->bare) continue;
      const Observed& value = observed[r].at(key);
      trials.push_back({std::arg(runs[r].weight_g[wanted->plane]), std::abs(value.vector),
                        std::sqrt(0.5 * value.variance)});
    }
    const auto found = balance_by_four_runs({0.0, std::abs(bare.vector), std::sqrt(0.5 * bare.variance)},
                                            trials, wanted->mass_g);
    if (!found) continue;
    ++result.observations;
    if (best && found->mass_sigma / found->mass >= best->mass_sigma / best->mass) continue;
    best = found;
    result.observation = text_of(key, bare);
  }
  if (!best) {
    result.refusal = "in no channel do the drives agree on a rotor that answers to the trial weight linearly";
    return result;
  }
  result.refusal.clear();
  result.plane.resize(rotor.plane.size());
  result.plane[wanted->plane] = {best->mass, best->angle_rad, best->mass_sigma, best->angle_sigma_rad};
  result.agreement = best->agreement;
  return result;
}

}  // namespace

RotorBalance balance_rotor(const RotorConfig& rotor, const std::vector<WeightedRun>& runs) {
  RotorBalance refused;
  if (rotor.plane.empty())
    refused.refusal = rotor.name + ": vehicle.toml gives it no [[rotor.plane]] to put weights in";
  else if (runs.empty())
    refused.refusal = "there is no drive";
  if (!refused.refusal.empty()) return refused;
  const auto observed = common_observations(runs);
  if (observed.front().empty()) {
    refused.refusal = "no channel has a first order with confidence at a speed that all drives have";
    return refused;
  }
  bool phase = true;
  for (const WeightedRun& run : runs)
    for (const RotorOrders* const orders : run.orders) phase = phase && orders->vectors().has_phase(0);
  return phase ? by_influence(rotor, runs, observed) : by_amplitude(rotor, runs, observed);
}

}  // namespace roadbalance
