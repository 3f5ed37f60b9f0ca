#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

inline constexpr const char* kWeightCheckChannel = "RB_VERIFICATION";
inline constexpr std::size_t kMostWeightCheckBytes = 240;

enum class WeightCheckState : std::int32_t {
  kReadingBefore = 0,  ///< the recording before is being evaluated
  kNotComparable = 1,  ///< text: why
  kBeforeUnknown = 2,  ///< the drive before did not show this wheel's unbalance
  kAfterUnknown = 3,   ///< this drive does not show it yet
  kKnown = 4,
};

enum class WeightCheckVerdict : std::int32_t {
  kOpen = 0,       ///< not known well enough yet
  kGood = 1,       ///< what is left is no more than a shop leaves
  kLess = 2,       ///< less than before, and more than a shop leaves
  kUnchanged = 3,  ///< no less and no more than before by what is known
  kMore = 4,       ///< more than before
};

/// The place of the weights, as the change of the unbalance shows it.
enum class WeightPlacement : std::int32_t {
  kNotJudged = 0,  ///< no weights, or their effect is lost in the uncertainty
  kAsWanted = 1,   ///< the unbalance changed as the weights should change it
  kMirrored = 2,   ///< as if they were beyond the reference point: angle counted the wrong way round
  kOpposite = 3,   ///< as if they were at the heavy spot, not opposite to it
  kElsewhere = 4,  ///< in none of these ways
  kNoEffect = 5,   ///< as if nothing had been fitted
};

/// The drive before the weights beside the one after, of one wheel; fields as in common/wire/verification_t.
struct WeightCheck {
  std::int32_t wheel = 0;
  std::int64_t time_ns = 0;
  WeightCheckState state = WeightCheckState::kReadingBefore;
  WeightCheckVerdict verdict = WeightCheckVerdict::kOpen;
  WeightPlacement placement = WeightPlacement::kNotJudged;
  bool fitted_known = false;
  Eigen::Vector2d before_g = Eigen::Vector2d::Zero(), after_g = Eigen::Vector2d::Zero();
  Eigen::Matrix2d before_covariance_g2 = Eigen::Matrix2d::Zero(),
                  after_covariance_g2 = Eigen::Matrix2d::Zero();
  Eigen::Vector2d fitted_g = Eigen::Vector2d::Zero();
  double weight_radius_m = 0.0;
  double reduction = 0.0, sigma_reduction = 0.0;
  std::string text{};  ///< cut after kMostWeightCheckBytes
};

std::vector<std::uint8_t> encode(const WeightCheck& check);
std::optional<WeightCheck> decode_weight_check(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
