#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// A node's scan with what its block says of it.
struct QualifiedRow {
  std::array<std::int32_t, kChannels> counts{};
  std::int64_t time_ns = 0;
  std::int32_t overload = 0;
  std::int32_t quality = 0;
};

/// What of two scans' quality is true of both together.  A gap before one of them is not: nothing that takes
/// them together reaches across.
std::int32_t worst_of(std::int32_t a, std::int32_t b);

/// Every factor-th scan behind reduction_taps(), all channels alike, without delay.
///
/// A scan is given where all that the filter reaches are there in one run; it stands for as many to each
/// side: it is overloaded if one of them was, its angles are known as well as the worst of them.  Of a wheel
/// whose angle one of them does not know the references are 0.
class RowDecimator {
 public:
  explicit RowDecimator(int factor);

  struct Reduced {
    QualifiedRow row;
    std::int64_t index = 0;  ///< of the scans that are left: old index / factor
  };
  /// The next scan of a run.
  /// @param index  counted from the beginning; one that does not follow the one before begins a new run
  std::optional<Reduced> add(const QualifiedRow& row, std::int64_t index);

 private:
  struct Beside {
    std::int64_t time_ns;
    std::int32_t overload, quality;
  };
  QualifiedRow filtered() const;

  const int factor_;
  const Eigen::VectorXd taps_;
  Eigen::Matrix<double, kChannels, Eigen::Dynamic> history_;  ///< column filled_ - 1 the newest
  std::vector<Beside> beside_;                                ///< [column]
  Eigen::Index filled_ = 0;
  std::int64_t next_index_ = 0;
};

}  // namespace roadbalance
