#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra.hpp"

namespace roadbalance {

/// Cross spectra of some channels at the bins of a band; empty if no bin lies in it.
struct BandSpectra {
  std::vector<double> frequency_hz;      ///< [bin]
  std::vector<Eigen::MatrixXcd> matrix;  ///< [bin], [channel x channel] as CrossSpectra::matrix
  int averages = 0;
  double independent_averages = 0.0;
};

/// The bins from low_hz to high_hz, both included: none where the band is narrower than the bins' distance
/// and lies between two, beyond half the rate, or ends below its beginning.
BandSpectra spectra_in_band(const CrossSpectra& spectra, double low_hz, double high_hz);

/// How one channel shows a signal that others show, too.
struct ChannelMatch {
  enum class Verdict {
    kMatched,
    kNoCoherence,  ///< it does not show that signal
    kInverted,     ///< it shows it upside down
    kNoDelay,      ///< its phase against the others is not that of a gain and a delay
    kOtherSize,    ///< it shows it so much larger or smaller that it is no mismatch but crosstalk or a wrong
                   ///< range
  };
  Verdict verdict = Verdict::kNoCoherence;
  double coherence = 0.0;                     ///< squared, with the others: mean over the band
  double gain = 1.0, gain_sigma = 0.0;        ///< over the reference's
  double delay_s = 0.0, delay_sigma_s = 0.0;  ///< behind the reference
  double misfit_rad = 0.0;  ///< rms of its phase about that of the delay, over the bins used
};

struct ChannelMatches {
  enum class Reason {
    kNone,
    kTooShort,    ///< fewer than kLeastAverages
    kNoTwoAlike,  ///< or the band is empty
    kReference,   ///< none of the reference is matched
  };
  Reason refusal = Reason::kNone;
  std::vector<ChannelMatch> channel{};  ///< empty if there is a refusal
};

/// Gain and delay of each channel from cross spectra, relative to the median over `reference`.
///
/// The channel that agrees best with all others is the pilot p.  Over the bins at which both are coherent,
///
///     H_k = sum over the others m of S_mk conj(S_mp) / sum of |S_mp|^2
///
/// is k over p, whatever noise of its own either has (two channels alone: S_pk / S_pp).  With the coherence
/// g^2 of k and p and n averages the phase of H_k has the variance (1 - g^2) / (2 n g^2), |H_k| / gain alike
/// (Bendat, Piersol, Random Data, 4th ed., section 9.2); weighted by its inverse the line of phase over
/// frequency through 0 gives the delay, the mean of |H_k| the gain.
///
/// @param reference  places of channels whose median is the reference; those that are not matched do not
/// count
/// @return by channel; the figures of those not matched show what was seen
ChannelMatches match_channels(const BandSpectra& spectra, const std::vector<int>& reference);

/// @param values  in any order, at least one
double median(std::vector<double> values);

/// A bin counts if both channels show there the same signal.
inline constexpr double kLeastCoherence = 0.9;
/// With fewer, noise alone would look coherent.
inline constexpr int kLeastAverages = 10;
/// Share of the bins with the strongest signal that at least must count.
inline constexpr double kLeastShare = 0.5;
/// A phase further from a delay's than this and three of its sigmas is no delay's: one degree.
inline constexpr double kMostMisfit_rad = 0.01745;

}  // namespace roadbalance
