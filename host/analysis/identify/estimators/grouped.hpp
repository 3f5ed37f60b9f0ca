#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "host/analysis/identify/confidence.hpp"
#include "host/analysis/identify/estimators/estimator.hpp"

namespace roadbalance {

/// Sums of stretches driven at about one speed, by speed.
template <typename Sums>
struct BySpeed {
  static constexpr double kClass_m_s = 1.0;  ///< width of a class

  std::map<int, Sums> at;

  static int key(double speed_m_s) { return static_cast<int>(speed_m_s / kClass_m_s); }

  BySpeed& operator+=(const BySpeed& other) {
    for (const auto& [key, sums] : other.at) at[key] += sums;
    return *this;
  }
};

/// Sums of parts of a drive, dealt out in turn to the groups of the jackknife.
///
/// @tparam Sums  of a part; an empty one is made by default, two add by +=
template <typename Sums>
class Grouped {
 public:
  static constexpr std::size_t kGroups = 10;

  void add(double speed_m_s, const Sums& part) {
    group_[parts_++ % kGroups].at[BySpeed<Sums>::key(speed_m_s)] += part;
  }

  /// How many classes of speed there are.
  std::size_t speeds() const { return all().at.size(); }

  BySpeed<Sums> all() const {
    BySpeed<Sums> sum;
    for (const auto& group : group_) sum += group;
    return sum;
  }

  static constexpr std::size_t kLeastGroups = 4;  ///< fewer: the uncertainty has no bound

  /// Covariance of the result of `solve` by the groups, widened because they are few; nothing: they
  /// are too few.
  template <typename Solve>
  std::optional<UnknownMatrix> covariance(const Solve& solve) const {
    const std::vector<BySpeed<Sums>> groups(group_.begin(), group_.begin() + std::min(parts_, kGroups));
    if (groups.size() < kLeastGroups) return std::nullopt;
    auto covariance = jackknife_covariance(groups, solve);
    if (covariance) *covariance *= few_groups_factor(static_cast<double>(groups.size()));
    return covariance;
  }

  /// `solve` of all, with the covariance that the groups show; NaN, with a diagnostic, where nothing is
  /// determined.
  /// @param solve  const BySpeed<Sums>& -> std::optional<UnknownVector>, as EstimatorAnswer::x
  template <typename Solve>
  EstimatorAnswer solve(const Question& question, const Solve& solve) const {
    return judged(question, solve(all()), covariance(solve));
  }

 private:
  std::array<BySpeed<Sums>, kGroups> group_{};
  std::size_t parts_ = 0;
};

/// An answer from what was solved: rows of what was not asked are 0, of what is not known NaN.
EstimatorAnswer judged(const Question& question, const std::optional<UnknownVector>& x,
                       const std::optional<UnknownMatrix>& covariance);

/// The values taken as known: EstimatorAnswer::x of a question that asks for nothing.
UnknownVector known_unknowns(const Question& question);

}  // namespace roadbalance
