#pragma once

#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra_kernels.hpp"
#include "common/dsp/fft.hpp"
#include "common/dsp/psd.hpp"
#include "common/process/aligned_memory.hpp"

namespace roadbalance {

/// One-sided spectral densities of all pairs of some signals by Welch's method, normalised as WelchPsd:
///
///     G_ab[k] = c / (rate sum(w^2)) * mean over segments of conj(X_a[k]) X_b[k],   X = DFT(w x)
///
/// G_ab is what SciPy calls csd(a, b); unit of a times unit of b per Hz.
///
/// Segments wait until eight are together: the sums of all pairs are far larger than a near cache (4.5 MB of
/// 16 channels and 4096 samples), and are then gone through once for eight.
class CrossSpectra {
 public:
  struct Settings {
    WelchPsd::Settings welch;
    int channels;  ///< >= 1
    /// Segments that an exponential average remembers: each new one weighs 1 / memory, the first ones all
    /// alike.  0: linear average, all segments alike for ever.
    int memory = 0;
    bool hold_peaks = false;
    bool remove_means = false;  ///< of each segment: what rests would leak into the lowest bins
  };

  /// @throws std::invalid_argument
  explicit CrossSpectra(const Settings& settings);

  /// Memory that such spectra take, about: sums of all pairs, the segments that wait, the one being filled.
  static std::size_t bytes(int channels, int segment);

  /// Takes further samples, without a hole.
  /// @param samples  [channel x sample]
  void add(const Eigen::Ref<const Eigen::MatrixXd>& samples);
  /// Samples are missing: the segment that the hole cuts is dropped, what was averaged stays.
  void gap() { filled_ = 0; }
  /// Forgets everything.
  void reset();

  int channels() const { return settings_.channels; }
  int bins() const { return fft_.bins(); }
  double step_hz() const { return step_hz_; }
  double enbw_hz() const { return enbw_hz_; }
  /// Segments averaged.
  int averages() const { return averages_; }
  /// Segments side by side whose average would scatter as much: those that overlap count for less.
  double independent_averages() const;

  /// [bins] G_ab; zero before the first segment is full.
  std::vector<std::complex<double>> density(int a, int b) const;
  /// [bins] G_aa.
  std::vector<double> density(int a) const;
  /// [bins] the greatest that any one segment had; zero if not asked for.
  std::vector<double> peak_density(int a) const;
  /// [channel x channel] G of one bin.
  Eigen::MatrixXcd matrix(int bin) const;

 private:
  using Lane = BinLane;
  static constexpr int kLane = kBinsOfLane;
  static constexpr int kBatch = kSegmentsOfBatch;
  static constexpr int kAtOnce =
      8;  ///< channels whose segments are got ready for the transform, in a near cache

  void add_segment();
  void weigh_newest();
  void sum_up() const;
  void hold_peaks(int tile, const Lane* lines) const;
  std::size_t place(int tile, int a, int b) const;
  double one_sided(int bin) const;

  Settings settings_;
  RealFft fft_;
  std::vector<double> window_;
  Eigen::Index hop_;
  int tiles_, pairs_;
  double step_hz_, enbw_hz_, scale_;
  Eigen::MatrixXd history_;  ///< [channel x sample] the segment that is being filled, a ring
  Eigen::Index next_ = 0;    ///< column of the next sample
  /// Lanes from one prepared channel to the next, more than a segment has: a power of two apart they would
  /// all need the same lines of the cache.
  std::size_t column_;
  std::vector<Lane> columns_;
  Eigen::Index filled_ = 0;
  mutable int waiting_ = 0;
  std::size_t line_, segment_;       ///< lanes of the batch from one channel, one segment to the next
  AlignedVector<Lane> batch_;        ///< [segment][channel][tile][re, im]
  mutable AlignedVector<Lane> sum_;  ///< [tile][pair][re, im], weighted mean of those summed up
  mutable std::vector<Lane> peak_;   ///< [tile][channel]
  int averages_ = 0;
  mutable int summed_ = 0;
  std::vector<double> overlap_;  ///< [k - 1] squared correlation of segments k apart
  std::vector<double> recent_;   ///< [k - 1] weight in the average of the segment k before the newest
  std::vector<double> lagged_;   ///< [k] sum over segments of weight times weight k apart
};

}  // namespace roadbalance
