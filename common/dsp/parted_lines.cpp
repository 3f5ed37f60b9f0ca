#include "common/dsp/parted_lines.hpp"

#include <cstring>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

template <int kLanes>
using Vector = typename Lanes<kLanes>::Vector;

/// Real and imaginary parts of as many complex numbers as a vector holds doubles.
template <int kLanes, int... kIndex>
[[gnu::always_inline]] inline void part(const double* numbers, Vector<kLanes>& real,
                                        Vector<kLanes>& imaginary, std::integer_sequence<int, kIndex...>) {
  Vector<kLanes> first, second;
  std::memcpy(&first, numbers, sizeof first);
  std::memcpy(&second, numbers + kLanes, sizeof second);
  real = __builtin_shufflevector(first, second, (2 * kIndex)...);
  imaginary = __builtin_shufflevector(first, second, (2 * kIndex + 1)...);
}

/// The same, from the last to the first.
template <int kLanes, int... kIndex>
[[gnu::always_inline]] inline void part_backwards(const double* numbers, Vector<kLanes>& real,
                                                  Vector<kLanes>& imaginary,
                                                  std::integer_sequence<int, kIndex...>) {
  Vector<kLanes> first, second;
  std::memcpy(&first, numbers, sizeof first);
  std::memcpy(&second, numbers + kLanes, sizeof second);
  real = __builtin_shufflevector(first, second, (2 * (kLanes - 1 - kIndex))...);
  imaginary = __builtin_shufflevector(first, second, (2 * (kLanes - 1 - kIndex) + 1)...);
}

/// Where the parts of a bin lie; the real one, the imaginary one a lane behind it.
[[gnu::always_inline]] inline std::size_t place(std::size_t bin) {
  return bin / kBinsOfLane * 2 * kBinsOfLane + bin % kBinsOfLane;
}

template <int kLanes>
[[gnu::always_inline]] inline void store(double* lanes, std::size_t bin, const Vector<kLanes>& real,
                                         const Vector<kLanes>& imaginary) {
  std::memcpy(lanes + place(bin), &real, sizeof real);
  std::memcpy(lanes + place(bin) + kBinsOfLane, &imaginary, sizeof imaginary);
}

template <int kLanes>
[[gnu::always_inline]] inline void part_all(const double* lines, std::size_t count, double* lanes) {
  std::size_t k = 0;
  for (; k + kLanes <= count; k += kLanes) {
    Vector<kLanes> real, imaginary;
    part<kLanes>(lines + 2 * k, real, imaginary, std::make_integer_sequence<int, kLanes>());
    store<kLanes>(lanes, k, real, imaginary);
  }
  for (; k < count; ++k) {
    lanes[place(k)] = lines[2 * k];
    lanes[place(k) + kBinsOfLane] = lines[2 * k + 1];
  }
}

/// X[M - k] = conj((Z[k] + conj Z[M - k]) / 2 - u[k] (Z[k] - conj Z[M - k])) comes with X[k].
template <int kLanes, int... kIndex>
[[gnu::always_inline]] inline void untangle_all(double* z, const double* turn, std::size_t pairs,
                                                double* lanes, std::integer_sequence<int, kIndex...> index) {
  z[2 * pairs] = z[0];
  z[2 * pairs + 1] = z[1];
  // X[M - k] of the turn before, from the least k on: those of a lane begin one bin further.
  Vector<kLanes> last_re = {}, last_im = {};
  std::size_t k = 0;
  for (; 2 * k < pairs; k += kLanes) {
    Vector<kLanes> re, im, far_re, far_im, u_re, u_im;
    part<kLanes>(z + 2 * k, re, im, index);
    part_backwards<kLanes>(z + 2 * (pairs - k + 1 - kLanes), far_re, far_im, index);
    std::memcpy(&u_re, turn + place(k), sizeof u_re);
    std::memcpy(&u_im, turn + place(k) + kBinsOfLane, sizeof u_im);
    const Vector<kLanes> half_re = 0.5 * (re + far_re), half_im = 0.5 * (im - far_im), off_re = re - far_re,
                         off_im = im + far_im;
    const Vector<kLanes> turned_re = u_re * off_re - u_im * off_im, turned_im = u_re * off_im + u_im * off_re;
    store<kLanes>(lanes, k, half_re + turned_re, half_im + turned_im);
    re = half_re - turned_re;
    im = turned_im - half_im;
    // X[M - k], and what lies above it in the lane, which came before.
    store<kLanes>(lanes, pairs - k,
                  __builtin_shufflevector(re, last_re, (kIndex == 0 ? 0 : 2 * kLanes - kIndex)...),
                  __builtin_shufflevector(im, last_im, (kIndex == 0 ? 0 : 2 * kLanes - kIndex)...));
    last_re = re;
    last_im = im;
  }
  store<kLanes>(lanes, k, __builtin_shufflevector(last_re, last_re, (kIndex == 0 ? 0 : kLanes - kIndex)...),
                __builtin_shufflevector(last_im, last_im, (kIndex == 0 ? 0 : kLanes - kIndex)...));
  lanes[place(k)] = z[2 * k];  // its own mirror image
  lanes[place(k) + kBinsOfLane] = -z[2 * k + 1];
}

RB_AVX512 void part_avx512(const double* lines, std::size_t count, double* lanes) {
  part_all<8>(lines, count, lanes);
}
RB_AVX2 void part_avx2(const double* lines, std::size_t count, double* lanes) {
  part_all<4>(lines, count, lanes);
}
void part_plain(const double* lines, std::size_t count, double* lanes) {
  part_all<2>(lines, count, lanes);
}

RB_AVX512 void untangle_avx512(double* z, const double* turn, std::size_t pairs, double* lanes) {
  untangle_all<8>(z, turn, pairs, lanes, std::make_integer_sequence<int, 8>());
}
RB_AVX2 void untangle_avx2(double* z, const double* turn, std::size_t pairs, double* lanes) {
  untangle_all<4>(z, turn, pairs, lanes, std::make_integer_sequence<int, 4>());
}
void untangle_plain(double* z, const double* turn, std::size_t pairs, double* lanes) {
  untangle_all<2>(z, turn, pairs, lanes, std::make_integer_sequence<int, 2>());
}

}  // namespace

void part_lines(const std::complex<double>* lines, std::size_t count, BinLane* lanes) {
  static const auto by = for_this_processor(part_avx512, part_avx2, part_plain);
  by(reinterpret_cast<const double*>(lines), count, lanes->of);  // as the standard lays complex numbers out
}

void untangle_pairs(double* z, const BinLane* turn, std::size_t pairs, BinLane* lanes) {
  static const auto by = for_this_processor(untangle_avx512, untangle_avx2, untangle_plain);
  by(z, turn->of, pairs, lanes->of);
}

}  // namespace roadbalance
