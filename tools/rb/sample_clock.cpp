#include "tools/rb/sample_clock.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roadbalance {

namespace {

struct Piece {
  std::size_t begin, end;  // samples without a hole between them
  double mean_index = 0.0, mean_s = 0.0, square = 0.0, product = 0.0;
};

Piece piece_of(std::span<const double> stamp_s, std::size_t begin, std::size_t end) {
  Piece piece{begin, end};
  const auto n = static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i) piece.mean_s += stamp_s[i] / n;
  piece.mean_index = 0.5 * static_cast<double>(begin + end - 1);
  for (std::size_t i = begin; i < end; ++i) {
    const double off = static_cast<double>(i) - piece.mean_index;
    piece.square += off * off;
    piece.product += off * (stamp_s[i] - piece.mean_s);
  }
  return piece;
}

std::vector<Piece> pieces_of(std::span<const double> stamp_s, double nominal_hz) {
  const double longest_s = std::min(1.5, 50.0 / nominal_hz);
  std::vector<Piece> pieces;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= stamp_s.size(); ++i) {
    if (i < stamp_s.size() && stamp_s[i] - stamp_s[i - 1] <= longest_s) continue;
    pieces.push_back(piece_of(stamp_s, begin, i));
    begin = i;
  }
  return pieces;
}

}  // namespace

SampleClock fit_sample_clock(std::span<const double> stamp_s, double nominal_hz) {
  if (stamp_s.size() < 3) throw std::invalid_argument("fewer than 3 samples");
  const auto pieces = pieces_of(stamp_s, nominal_hz);
  double square = 0.0, product = 0.0;
  for (const auto& piece : pieces) {
    square += piece.square;
    product += piece.product;
  }
  if (!(square > 0.0 && product > 0.0)) throw std::invalid_argument("time does not advance");
  const double period_s = product / square;

  SampleClock clock;
  clock.index.resize(stamp_s.size());
  std::int64_t next = 0;
  for (const auto& piece : pieces) {
    // Where the line through the first piece meets the middle of this one.
    const double middle = pieces[0].mean_index + (piece.mean_s - pieces[0].mean_s) / period_s;
    const double begin = middle - (piece.mean_index - static_cast<double>(piece.begin));
    const std::int64_t first = std::max<std::int64_t>(next, std::llround(begin));
    if (first > next) clock.hole.push_back({stamp_s[piece.begin - 1], first - next});
    next = first;
    for (std::size_t i = piece.begin; i < piece.end; ++i) clock.index[i] = next++;
  }

  double mean_index = 0.0, mean_s = 0.0;
  const auto n = static_cast<double>(stamp_s.size());
  for (std::size_t i = 0; i < stamp_s.size(); ++i) {
    mean_index += static_cast<double>(clock.index[i]) / n;
    mean_s += stamp_s[i] / n;
  }
  square = product = 0.0;
  for (std::size_t i = 0; i < stamp_s.size(); ++i) {
    const double off = static_cast<double>(clock.index[i]) - mean_index;
    square += off * off;
    product += off * (stamp_s[i] - mean_s);
  }
  clock.period_s = product / square;
  clock.first_s = mean_s - clock.period_s * mean_index;
  for (std::size_t i = 0; i < stamp_s.size(); ++i) {
    const double off = stamp_s[i] - clock.first_s - clock.period_s * static_cast<double>(clock.index[i]);
    clock.stamp_rms_s += off * off / n;
    clock.stamp_max_s = std::max(clock.stamp_max_s, std::abs(off));
  }
  clock.stamp_rms_s = std::sqrt(clock.stamp_rms_s);
  return clock;
}

}  // namespace roadbalance
