#pragma once

#include <array>
#include <complex>
#include <map>
#include <string>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/calibration/computed_references.hpp"

namespace roadbalance {

/// The wiring test of a loop-back: references that went through D/A converter, real filter and A/D converter
/// and came back as channels 13 .. 16, against those computed from the same edges.
///
/// With m = cos + j sin as they came back and c as computed, h = <m c*> / <|c|^2> is what the loop makes of
/// the angle, k = <m c> / <|c|^2> what it makes of the mirrored one; the phase of h over the wheel's speed is
/// a constant (datum) and a delay (filter):  arg h(f) = phi - 2 pi f delay.
class LoopBackComparison {
 public:
  /// @param rate_hz  of scans
  explicit LoopBackComparison(double rate_hz) : rate_hz_(rate_hz) {}

  /// Blocks of a node with a loop-back, as they come.
  void add(const ScanBlock& recorded, const ComputedReferences::Rows& computed);

  enum class Cause {
    kNone,          ///< it agrees
    kTooShort,      ///< hardly any scan could be compared
    kSilent,        ///< nothing comes back
    kOneSilent,     ///< of sine and cosine one does not come back
    kForeign,       ///< what comes back is no wheel's sine and cosine
    kLinesSwapped,  ///< it is the other wheel's
    kSineInverted,
    kCosineInverted,
    kBothInverted,
    kSwapped,          ///< sine for cosine
    kSwappedInverted,  ///< sine for cosine, and one or both of them inverted
    kUneven,           ///< gain or phase of sine and cosine differ
    kFilter,           ///< the angle is off by a delay: another filter than vehicle.toml's
    kDatum,            ///< the angle is off by the same at all speeds
    kAngle,            ///< the angle is off, and the drive's speeds do not show why
  };
  struct Verdict {
    Cause cause = Cause::kTooShort;
    double seconds = 0.0;                      ///< compared
    double gain = 0.0;                         ///< of the loop
    double worst_rad = 0.0;                    ///< angle error at the speed where it is largest
    double worst_hz = 0.0;                     ///< turns a second there
    double mean_rad = 0.0;                     ///< over the drive
    double constant_rad = 0.0, delay_s = 0.0;  ///< of arg h over speed
    double uneven = 0.0;                       ///< |k| / |h|
    double unexplained = 0.0;  ///< share of the power that no sine or cosine of either wheel explains
  };
  /// @param tolerance_rad  an angle error that is none
  Verdict verdict(std::size_t line, double tolerance_rad) const;

 private:
  static constexpr double kClass_hz = 1.0;
  struct Class {
    std::complex<double> straight, mirrored;
    double power = 0.0, turns_hz = 0.0;
    std::int64_t rows = 0;
  };
  struct Line {
    std::map<int, Class> of_speed;
    std::complex<double> last;
    bool follows = false;
    std::int64_t rows = 0, silent = 0;
    Eigen::Vector2d power = Eigen::Vector2d::Zero();  ///< of what came back, sin and cos
    /// Sums of what came back [sin, cos] with both wheels' computed [sin, cos, sin, cos]; a wheel whose angle
    /// is not known has 0.
    Eigen::Matrix<double, 2, 4> with = Eigen::Matrix<double, 2, 4>::Zero();
    Eigen::Matrix4d among = Eigen::Matrix4d::Zero();
  };
  void add_row(const std::array<std::int32_t, kChannels>& back,
               const std::array<std::int32_t, kChannels>& made, const std::array<bool, kEncoderLines>& known);
  static bool fit_speed(const Line& line, Verdict& verdict);

  double rate_hz_;
  std::array<Line, kEncoderLines> line_;
  std::int64_t epoch_ = 0, next_scan_ = -1;
};

/// The probable fault and where to look; empty: none.
/// @param filter  of vehicle.toml
std::string explain(const LoopBackComparison::Verdict& verdict, const FilterConfig& filter);

}  // namespace roadbalance
