#include "host/identify/confidence.hpp"

namespace roadbalance {

std::optional<UnknownMatrix> jackknife_covariance(const std::vector<DriveMoments>& groups,
                                                  const Geometry& geometry, const ParameterVector& known) {
  std::vector<UnknownVector> partial;
  for (std::size_t left_out = 0; left_out < groups.size(); ++left_out) {
    if (groups[left_out].sections == 0) continue;
    DriveMoments rest;
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (g != left_out) rest += groups[g];
    const auto x = solve(rest, geometry, known);
    if (!x) return std::nullopt;
    partial.push_back(*x);
  }
  if (partial.size() < 2) return std::nullopt;
  UnknownVector mean = UnknownVector::Zero();
  for (const auto& x : partial) mean += x;
  const auto n = static_cast<double>(partial.size());
  mean /= n;
  UnknownMatrix covariance = UnknownMatrix::Zero();
  for (const auto& x : partial) covariance += (x - mean) * (x - mean).transpose();
  return covariance * ((n - 1.0) / n);
}

}  // namespace roadbalance
