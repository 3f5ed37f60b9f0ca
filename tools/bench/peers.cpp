#include <cstring>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <fftw3.h>
#include <Eigen/Core>

#include "common/bus/codec.hpp"
#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/process/aligned_memory.hpp"
#include "common/types/crc32c.hpp"
#include "tools/bench/contest.hpp"

// Our kernels beside their peers, on one thread, in interleaved rounds: a line of JSON for each row, which
// tools/bench/run puts into its table.

namespace roadbalance::bench {
namespace {

constexpr Eigen::Index kChannels = 16, kOrder = 5;

/// All pairs of 16 channels, segments of 4096, Hann, half overlapping; and what must be moved for it,
/// whatever is computed: the samples of each channel, which lie ready for the transform, the lines of a batch
/// of segments, which are written and read once, and the sums, which are read and written for each batch.  No
/// near cache holds any of them.
void spectra() {
  constexpr int kSegment = 4096, kHops = 16;
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(kChannels, kHops * kSegment / 2);
  CrossSpectra spectra(
      {.welch = {.rate_hz = 10'000.0, .segment = kSegment}, .channels = kChannels, .memory = 20});
  double* const in = fftw_alloc_real(kSegment);
  fftw_complex* const out = fftw_alloc_complex(kSegment / 2 + 1);
  fftw_plan estimated = fftw_plan_dft_r2c_1d(kSegment, in, out, FFTW_ESTIMATE);
  fftw_plan measured = fftw_plan_dft_r2c_1d(kSegment, in, out, FFTW_MEASURE);
  for (int n = 0; n < kSegment; ++n) in[n] = x(n % kChannels, n);
  const auto transforms = [](fftw_plan plan) {
    for (int n = 0; n < kHops * kChannels; ++n) fftw_execute(plan);
  };
  AlignedVector<double> sums_memory(kChannels * (kChannels + 1) * (kSegment / 2 + 1));
  Eigen::Map<Eigen::ArrayXd> sums(sums_memory.data(), std::ssize(sums_memory));
  const Eigen::MatrixXd signals = Eigen::MatrixXd::Random(kHops * kSegment / 2 + kSegment / 2, kChannels);
  constexpr int kLine = kSegment / 2 + 8;  // complex numbers from one to the next
  AlignedVector<double> lines_memory(2 * kLine * kChannels * kSegmentsOfBatch);
  Eigen::Map<Eigen::ArrayXd> lines(lines_memory.data(), std::ssize(lines_memory));
  std::vector<Contender> run(4);
  run[0].work = [&] { spectra.add(x); };
  run[1].work = [&] { transforms(measured); };
  run[2].work = [&] { transforms(estimated); };
  run[3].work = [&] {
    for (int hop = 0; hop < kHops; ++hop) {
      const int waiting = hop % kSegmentsOfBatch;
      for (int c = 0; c < kChannels; ++c)
        fftw_execute_dft_r2c(measured, const_cast<double*>(&signals(hop * kSegment / 2, c)),
                             reinterpret_cast<fftw_complex*>(&lines(2 * kLine * (waiting * kChannels + c))));
      if (waiting + 1 == kSegmentsOfBatch) sums = 0.999 * sums + lines.sum();
    }
  };
  compete(run);
  const auto ns = [&](std::size_t i) { return 1e9 * median(run[i].cpu_s) / static_cast<double>(x.size()); };
  const char* const unit = "ns/ch-sample";
  tell("cross spectra 16 x 16", unit, ns(0), "FFTW alone, measured", ns(1), ratio(run[0], run[1]));
  tell("the same", unit, ns(0), "FFTW alone, estimated", ns(2), ratio(run[0], run[2]));
  tell("the same", unit, ns(0), "and what must be moved", ns(3), ratio(run[0], run[3]));
  fftw_destroy_plan(estimated);
  fftw_destroy_plan(measured);
  fftw_free(in);
  fftw_free(out);
}

/// Order 5, all states, 16 channels; the peer is the plain loop over channels, states, states.
void filter() {
  const DiscreteFilter design = discretise_ramp_invariant(butterworth(kOrder, 30.0), 1.0 / 2000.0);
  const Eigen::ArrayXXd x = Eigen::ArrayXXd::Random(kChannels, 2000);
  StateFilter filter(design, kChannels);
  double plain[kChannels][kOrder] = {}, last[kChannels] = {};
  std::vector<Contender> run(2);
  run[0].work = [&] {
    for (Eigen::Index t = 0; t < x.cols(); ++t) filter.update(x.col(t));
  };
  run[1].work = [&] {
    for (Eigen::Index t = 0; t < x.cols(); ++t)
      for (Eigen::Index c = 0; c < kChannels; ++c) {
        double next[kOrder];
        for (Eigen::Index i = 0; i < kOrder; ++i) {
          next[i] = design.b0(i) * last[c] + design.b1(i) * x(c, t);
          for (Eigen::Index j = 0; j < kOrder; ++j) next[i] += design.A(i, j) * plain[c][j];
        }
        std::memcpy(plain[c], next, sizeof next);
        last[c] = x(c, t);
      }
    asm volatile("" : : "r"(plain) : "memory");
  };
  compete(run);
  const auto ns = [&](std::size_t i) { return 1e9 * median(run[i].cpu_s) / static_cast<double>(x.size()); };
  tell("state filter, order 5", "ns/ch-sample", ns(0), "plain loop", ns(1), ratio(run[0], run[1]));
}

/// 20 scans of 16 channels: from counts to the sealed datagram; the peer is the CRC alone.
void pack() {
  ScanBlock block;
  std::mt19937 random(3);
  for (auto& row : block.counts)
    for (auto& count : row) count = static_cast<std::int32_t>(random() % 2'000'000) - 1'000'000;
  block.header = {
      .node = 1, .epoch = 1, .sequence = 1, .first_scan = 0, .scans = kScansPerBlock, .time_ns = 0};
  block.period_ps = 500'000'000;
  SealedBlock sealed, taken;
  seal(block, sealed);
  const std::vector<std::uint8_t> bytes(sealed.bytes().begin(), sealed.bytes().end());
  volatile std::uint32_t crc = 0;
  std::vector<Contender> run(3);
  run[0].work = [&] { seal(block, sealed); };
  run[1].work = [&] { crc = crc32c(bytes); };
  run[2].work = [&] {
    if (accept(bytes, taken) != Refusal::kNone) throw std::runtime_error("a sealed block is refused");
  };
  compete(run);
  const auto ns = [&](std::size_t i) {
    return 1e9 * median(run[i].cpu_s) / static_cast<double>(kScansPerBlock * kChannels);
  };
  tell("pack + CRC", "ns/ch-sample", ns(0), "CRC-32C alone", ns(1), ratio(run[0], run[1]));
  tell("accept a block", "ns/ch-sample", ns(2), "CRC-32C alone", ns(1), ratio(run[2], run[1]));
}

}  // namespace
}  // namespace roadbalance::bench

int main() {
  using namespace roadbalance::bench;
  spectra();
  filter();
  pack();
}
