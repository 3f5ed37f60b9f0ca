#include "host/identify/confidence.hpp"

#include <algorithm>
#include <iterator>

namespace roadbalance {

UnknownMatrix jackknife_covariance(const std::vector<UnknownVector>& left_out) {
  UnknownVector mean = UnknownVector::Zero();
  for (const auto& x : left_out) mean += x;
  const auto n = static_cast<double>(left_out.size());
  mean /= n;
  UnknownMatrix covariance = UnknownMatrix::Zero();
  for (const auto& x : left_out) covariance += (x - mean) * (x - mean).transpose();
  return covariance * ((n - 1.0) / n);
}

std::optional<UnknownMatrix> jackknife_covariance(const std::vector<DriveMoments>& groups,
                                                  const Geometry& geometry, const ParameterVector& known) {
  std::vector<DriveMoments> driven;
  std::copy_if(groups.begin(), groups.end(), std::back_inserter(driven),
               [](const DriveMoments& group) { return group.sections > 0; });
  return jackknife_covariance(driven, [&](const DriveMoments& rest) { return solve(rest, geometry, known); });
}

}  // namespace roadbalance
