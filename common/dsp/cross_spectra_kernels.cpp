#include "common/dsp/cross_spectra_kernels.hpp"

#include <cstring>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

template <int kLanes>
using Vector = typename Lanes<kLanes>::Vector;

// By reference: a function that returns such a vector would have one more way to be called on each processor.
template <typename Value>
[[gnu::always_inline]] inline void load(Value& value, const double* from) {
  std::memcpy(&value, from, sizeof value);
}

template <typename Value>
[[gnu::always_inline]] inline void store(const Value& value, double* to) {
  std::memcpy(to, &value, sizeof value);
}

/// For two rows of a matrix that is turned over: each pair of blocks of `kFar` elements off the diagonal
/// changes places.
template <int kFar, int... kIndex>
[[gnu::always_inline]] inline void exchange(auto& upper, auto& lower, std::integer_sequence<int, kIndex...>) {
  constexpr int kLanes = sizeof...(kIndex);
  const auto up = upper, low = lower;
  upper = __builtin_shufflevector(up, low, ((kIndex & kFar) != 0 ? kLanes + kIndex - kFar : kIndex)...);
  lower = __builtin_shufflevector(up, low, ((kIndex & kFar) != 0 ? kLanes + kIndex : kIndex + kFar)...);
}

template <int kLanes, int kFar = 1>
[[gnu::always_inline]] inline void transpose(Vector<kLanes>* row) {
  if constexpr (kFar < kLanes) {
#pragma GCC unroll 8
    for (int k = 0; k < kLanes; ++k)
      if ((k & kFar) == 0) exchange<kFar>(row[k], row[k + kFar], std::make_integer_sequence<int, kLanes>());
    transpose<kLanes, 2 * kFar>(row);
  }
}

/// So many channels at once as the vector holds, the rest by half of it.
template <int kLanes>
[[gnu::always_inline]] inline void taper(const Tapering& work, std::size_t first) {
  std::size_t c = first;
  for (; c + kLanes <= work.end; c += kLanes) {
    const double* in = work.in + c;
    double* const out = work.out + (c - work.first) * work.column;
    Vector<kLanes> mean;
    load(mean, work.mean + c);
    std::size_t n = 0;
    for (; n + kLanes <= work.samples; n += kLanes) {
      Vector<kLanes> row[kLanes];
#pragma GCC unroll 8
      for (int k = 0; k < kLanes; ++k, in += work.channels) {
        load(row[k], in);
        row[k] = (row[k] - mean) * work.window[n + static_cast<std::size_t>(k)];
      }
      transpose<kLanes>(row);
#pragma GCC unroll 8
      for (int k = 0; k < kLanes; ++k) store(row[k], out + static_cast<std::size_t>(k) * work.column + n);
    }
    for (; n < work.samples; ++n, in += work.channels)
      for (std::size_t k = 0; k < kLanes; ++k)
        out[k * work.column + n] = (in[k] - work.mean[c + k]) * work.window[n];
  }
  if constexpr (kLanes > 2) {
    if (c < work.end) taper<kLanes / 2>(work, c);
  } else {
    for (; c < work.end; ++c)
      for (std::size_t n = 0; n < work.samples; ++n)
        work.out[(c - work.first) * work.column + n] =
            (work.in[n * work.channels + c] - work.mean[c]) * work.window[n];
  }
}

/// The value stays in a register: GCC would load it again wherever it is used, twice as often as a processor
/// can that multiplies as fast as it loads.
template <typename Value>
[[gnu::always_inline]] inline void hold(Value& value) {
#if defined(__clang__)
  (void)value;
#elif defined(__x86_64__)
  asm("" : "+v"(value));
#elif defined(__aarch64__)
  asm("" : "+w"(value));
#endif
}

/// kLanes of the tile's bins, from `bin` on.
template <int kLanes>
[[gnu::always_inline]] inline void sum_up_bins(const TileSums& tile, int bin) {
  constexpr int kSegments = kSegmentsOfBatch;
  BinLane* sum = tile.sum;
  // The next tile's lines and sums are in no near cache: they are asked for now; behind the last one that
  // does no harm.
  const std::size_t next_sums = tile.channels * (tile.channels + 1);
  for (std::size_t a = 0; a < tile.channels; ++a, sum += 2) {
    const BinLane* const own = tile.lines + a * tile.channel;
    Vector<kLanes> re[kSegments], im[kSegments], power;
    load(power, sum->of + bin);
    power *= tile.before;
    __builtin_prefetch(sum[next_sums].of, 1);
    __builtin_prefetch(sum[next_sums + 1].of, 1);
#pragma GCC unroll 8
    for (int s = 0; s < kSegments; ++s) {
      const BinLane* const line = own + static_cast<std::size_t>(s) * tile.segment;
      Vector<kLanes> x, y;
      load(x, line[0].of + bin);
      load(y, line[1].of + bin);
      __builtin_prefetch(line[2].of);
      __builtin_prefetch(line[3].of);
      re[s] = tile.weight[s] * x;
      im[s] = tile.weight[s] * y;
      power += re[s] * x;
      power += im[s] * y;
    }
    store(power, sum->of + bin);  // of a channel with itself: its imaginary part stays 0
    const BinLane* other = own;
    for (std::size_t b = a + 1; b < tile.channels; ++b) {
      other += tile.channel;
      sum += 2;
      // Two sums each, so that an addition need not wait for the one before it.
      Vector<kLanes> real, imaginary, real2 = {}, imaginary2 = {};
      load(real, sum[0].of + bin);
      load(imaginary, sum[1].of + bin);
      __builtin_prefetch(sum[next_sums].of, 1);
      __builtin_prefetch(sum[next_sums + 1].of, 1);
      real *= tile.before;
      imaginary *= tile.before;
#pragma GCC unroll 8
      for (int s = 0; s < kSegments; ++s) {
        const BinLane* const line = other + static_cast<std::size_t>(s) * tile.segment;
        Vector<kLanes> x, y;
        load(x, line[0].of + bin);
        load(y, line[1].of + bin);
        hold(x);
        hold(y);
        real += re[s] * x;
        real2 += im[s] * y;
        imaginary += re[s] * y;
        imaginary2 -= im[s] * x;
      }
      store(Vector<kLanes>(real + real2), sum[0].of + bin);
      store(Vector<kLanes>(imaginary + imaginary2), sum[1].of + bin);
    }
  }
}

template <int kLanes>
[[gnu::always_inline]] inline void sum_up(const TileSums& tile) {
  for (int bin = 0; bin < kBinsOfLane; bin += kLanes) sum_up_bins<kLanes>(tile, bin);
}

RB_AVX512 void taper_avx512(const Tapering& work) {
  taper<8>(work, work.first);
}
RB_AVX2 void taper_avx2(const Tapering& work) {
  taper<4>(work, work.first);
}
void taper_plain(const Tapering& work) {
  taper<2>(work, work.first);
}

RB_AVX512 void sum_up_avx512(const TileSums& tile) {
  sum_up<8>(tile);
}
RB_AVX2 void sum_up_avx2(const TileSums& tile) {
  sum_up<4>(tile);
}
void sum_up_plain(const TileSums& tile) {
  sum_up<2>(tile);
}

}  // namespace

void taper_columns(const Tapering& work) {
  static const auto by = for_this_processor(taper_avx512, taper_avx2, taper_plain);
  by(work);
}

void sum_up_tile(const TileSums& tile) {
  static const auto by = for_this_processor(sum_up_avx512, sum_up_avx2, sum_up_plain);
  by(tile);
}

}  // namespace roadbalance
