#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace roadbalance {

/// A column of samples that is a tachometer's signal, and the wheel whose encoder it is.
struct TachometerColumn {
  std::string channel;
  int wheel = 0;  ///< place in kWheelNames

  /// COLUMN=WHEEL; a column may have = in its name.
  /// @throws ConfigError saying what is wrong with it and what is allowed
  static TachometerColumn parse(const std::string& text);
};

/// Least and largest sample of a tachometer's signal, in its own unit.
struct TachometerLevels {
  double least = 0.0, largest = 0.0;
  std::int64_t samples = 0;

  void add(double value);  ///< NaN: there is no sample
};

/// Samples of a tachometer -> an instant for each pulse.
///
/// A pulse is where the signal rises through the middle of its levels after it was in their lowest quarter:
/// noise of less than a quarter of the way makes no second pulse.  Its instant is interpolated between the
/// samples below and above,
///
///     t = t_below + (middle - below) / (above - below) T.
///
/// A signal that leaps from one level to the other within a period T tells its instant no better than evenly
/// within T, which has the standard deviation T / sqrt(12); one that rises by a part p of the way is straight
/// there, and is taken to be p T / sqrt(12) off at the most.
///
/// Limits: levels are those of the whole file, so one spike moves them; both levels need a sample in each
/// turn.  Where samples are missing between below and above there is no pulse.
class TachometerPulses {
 public:
  /// @pre levels.largest > levels.least
  explicit TachometerPulses(const TachometerLevels& levels);

  /// The next sample; NaN: there is none.
  /// @param time_s    of it
  /// @param period_s  the sample before was taken so long before, or is missing
  /// @return instant of the pulse between the sample before and this one
  std::optional<double> add(double time_s, double period_s, double value);

  std::int64_t pulses() const { return pulses_; }
  double threshold() const { return middle_; }
  /// Standard deviation of a pulse's instant, rms over the pulses; 0 without any.
  double sigma_s() const;

 private:
  const double low_, middle_, way_;
  double before_, before_s_ = 0.0;  ///< the sample before; NaN: there is none
  bool was_low_ = false;            ///< since the last pulse
  std::int64_t pulses_ = 0;
  double squares_ = 0.0;  ///< sum of the variances of the instants, s^2
};

}  // namespace roadbalance
