#pragma once

#include <vector>

#include "host/analysis/orders/angle_sampler.hpp"

namespace roadbalance {

/// Samples in time -> rows in angle that hold the orders of interest and no folded ones.
///
///     samples ─▶ AngleSampler, rows as dense as samples ─▶ low-pass in the angle ─▶ every factor-th row
///
/// The low-pass is decimation_taps: orders up to kDecimationFlatTo rows_per_turn pass unchanged, and the rows
/// lie where the wheel stands, without delay.  The 16 rows it needs and the 32 samples that AngleSampler
/// needs around it are what an interruption costs.
class AngleResampler {
 public:
  /// @param settings  rows_per_turn: of the result, any number; the others as for AngleSampler
  /// @throws std::invalid_argument
  AngleResampler(const AngleSampler::Settings& settings, AngleSampler::Emit emit);
  AngleResampler(const AngleResampler&) = delete;
  AngleResampler& operator=(const AngleResampler&) = delete;

  void add(std::optional<double> angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values,
           std::uint32_t overload = 0) {
    sampler_.add(angle_rad, values, overload);
  }
  void interrupt() { sampler_.interrupt(); }

  std::int64_t slow_samples() const { return sampler_.slow_samples(); }
  /// Up to here orders are right to 2e-4.
  double highest_order() const;

 private:
  void take(const AngleRow& row);

  int rows_per_turn_;
  int factor_;
  Eigen::VectorXd taps_;
  Eigen::MatrixXd history_;  ///< [channel x row], column filled_ - 1 the newest
  struct Place {
    double time_s;
    std::uint32_t overload;
  };
  std::vector<Place> place_;  ///< of the rows in history_
  Eigen::Index filled_ = 0;
  bool restart_ = true;
  AngleRow out_;
  AngleSampler::Emit emit_;
  AngleSampler sampler_;
};

}  // namespace roadbalance
