#include "tools/import/sample_clock.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/types/block.hpp"

namespace roadbalance {
namespace {

/// Below kIndexLimit by more than a file has rows: no reader takes a block behind that.
constexpr double kMostMissing = 1e14;
static_assert(kMostMissing < 0.5 * static_cast<double>(kIndexLimit));

}  // namespace

double SampleClockFit::Piece::mean_row() const {
  return static_cast<double>(begin) + 0.5 * static_cast<double>(samples - 1);
}

double SampleClockFit::Piece::square() const {
  const auto n = static_cast<double>(samples);
  return n * (n * n - 1.0) / 12.0;
}

void SampleClockFit::add(double stamp_s) {
  if (rows_ == 0) first_s_ = stamp_s;
  const double longest_s = std::min(1.5, 50.0 / nominal_hz_);
  if (rows_ == 0 || stamp_s - last_s_ > longest_s) {
    if (piece_.size() > kMostHoles)
      throw std::invalid_argument("more than " + std::to_string(kMostHoles) +
                                  " holes; allowed: samples as often as rate_hz says");
    piece_.push_back({.begin = rows_, .before_s = last_s_});
  }
  Piece& piece = piece_.back();
  const auto row = static_cast<double>(rows_);
  const double late_s = stamp_s - first_s_ - row / nominal_hz_;
  // The mean row of those before, which are one fewer.
  const double from_mean = piece.samples > 0 ? row - piece.mean_row() : 0.0;
  ++piece.samples;
  piece.late_s += (late_s - piece.late_s) / static_cast<double>(piece.samples);
  piece.late_product += from_mean * (late_s - piece.late_s);
  last_s_ = stamp_s;
  ++rows_;
}

SampleClock SampleClockFit::clock() const {
  if (rows_ < 3) throw std::invalid_argument("fewer than 3 samples");
  const double nominal_s = 1.0 / nominal_hz_;
  double square = 0.0, product = 0.0;
  for (const Piece& piece : piece_) {
    square += piece.square();
    product += piece.late_product;
  }
  const double within_s = square > 0.0 ? nominal_s + product / square : 0.0;
  if (!(within_s > 0.0)) throw std::invalid_argument("time does not advance");

  SampleClock clock;
  std::vector<std::int64_t> missing;  // [piece] before it
  for (const Piece& piece : piece_) {
    const std::int64_t before = missing.empty() ? 0 : missing.back();
    // The line through the first piece, at the middle of this one.
    const double from_first_s =
        piece.late_s - piece_[0].late_s + (piece.mean_row() - piece_[0].mean_row()) * nominal_s;
    const double expected = piece_[0].mean_row() + from_first_s / within_s - piece.mean_row();
    if (!(expected < kMostMissing))
      throw std::invalid_argument("more than 1e14 samples are missing; allowed: holes that can be counted");
    missing.push_back(std::max<std::int64_t>(before, std::llround(expected)));
    if (missing.back() > before) clock.hole.push_back({piece.before_s, missing.back() - before, piece.begin});
  }

  // Sums of all samples by their index: the pieces' sums about their means, and those of the means.
  double mean_index = 0.0, mean_late_s = 0.0;
  const auto index_of = [&](std::size_t p) { return piece_[p].mean_row() + static_cast<double>(missing[p]); };
  const auto late_of = [&](std::size_t p) {
    return piece_[p].late_s - static_cast<double>(missing[p]) * nominal_s;
  };
  for (std::size_t p = 0; p < piece_.size(); ++p) {
    const double share = static_cast<double>(piece_[p].samples) / static_cast<double>(rows_);
    mean_index += share * index_of(p);
    mean_late_s += share * late_of(p);
  }
  for (std::size_t p = 0; p < piece_.size(); ++p) {
    const double samples = static_cast<double>(piece_[p].samples), off = index_of(p) - mean_index;
    square += samples * off * off;
    product += samples * off * (late_of(p) - mean_late_s);
  }
  clock.period_s = nominal_s + product / square;
  clock.first_s = first_s_ + mean_late_s - (product / square) * mean_index;
  return clock;
}

}  // namespace roadbalance
