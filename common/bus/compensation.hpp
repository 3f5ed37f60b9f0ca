#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/config/weight_stock.hpp"

namespace roadbalance {

inline constexpr const char* kCompensationChannel = "RB_COMPENSATION";

enum class WeightAction : std::int32_t { kKeep = 0, kMove = 1, kRemove = 2, kAdd = 3 };

struct WeightStep {
  WeightAction action = WeightAction::kAdd;
  WheelWeight weight;  ///< where it shall be; of one to remove where it is
  WheelWeight from;    ///< of one to move: where it is; of the same kind
};
inline constexpr std::size_t kMostWeightSteps = kMostFittedWeights + 2;

struct WeightPlan {
  std::vector<WeightStep> step{};  ///< at most kMostWeightSteps
  /// Moment that the steps add to what was on the wheel when its unbalance was found, g m.
  std::complex<double> applied_g_m = 0.0;

  /// The unbalance that is left, g m: from the estimate the prediction, from the truth the outcome.
  std::complex<double> residual_g_m(std::complex<double> unbalance_g_m) const {
    return unbalance_g_m + applied_g_m;
  }
};

struct BalanceVerdict {
  /// Expected rms of what is left after the plan, sqrt(|e|^2 + tr C), at the balance's weight radius.
  double residual_g = 0.0;
  double shop_g = 0.0;                  ///< what a shop leaves
  double permissible_g = 0.0;           ///< by ISO at the greatest speed driven, at the weight radius
  double permissible_grade_mm_s = 0.0;  ///< by which G
  double grade_mm_s = 0.0;              ///< that the expected residual is of, G
  /// Both by the mass of what turns, as ISO has it; else by all that is unsprung, which permits more.
  bool by_rotor = false;
  /// Ratio of the first-order force that is left to the one that was there, rms over the speeds driven; 1 if
  /// unknown.
  double force_left_share = 1.0;
  /// Why weights will not cure this, made plain and cut where it is sent; empty: they will.
  std::string incurable{};

  bool within_shop() const { return residual_g <= shop_g; }
  bool within_iso() const { return residual_g <= permissible_g; }
};
inline constexpr std::size_t kMostReasonBytes = 240;

enum class Advice : std::int32_t {
  kUnknown = 0,         ///< the unbalance is not known
  kSteps = 1,           ///< those of the plan
  kLeaveUncertain = 2,  ///< it may be none: it lies inside its own 95 % ellipse
  kLeaveSmall = 3,      ///< no weight there is would make it enough less
};

/// Advice on a wheel's unbalance; fields as in common/wire/compensation_t.
struct Compensation {
  std::int32_t wheel = 0;
  std::int64_t time_ns = 0;
  Advice advice = Advice::kUnknown;
  std::int32_t radii = 1;
  WeightPlan plan{};         ///< empty while nothing is known
  BalanceVerdict verdict{};  ///< of it
  double wanted_sigma_g = 0.0;
  double seconds_wanted = std::numeric_limits<double>::infinity();
  double seat_now_m_s2 = std::numeric_limits<double>::quiet_NaN();
  double seat_left_m_s2 = std::numeric_limits<double>::quiet_NaN();
};

std::vector<std::uint8_t> encode(const Compensation& message);
std::optional<Compensation> decode_compensation(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
