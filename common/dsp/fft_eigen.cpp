#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "common/dsp/fft.hpp"

namespace roadbalance {

struct RealFft::Plan {
  Eigen::FFT<double> fft;
  std::vector<double> in;
  std::vector<std::complex<double>> out;
};

RealFft::RealFft(int size) : size_(size) {
  if (size < 2) throw std::invalid_argument("FFT size must be at least 2");
  plan_ = std::make_unique<Plan>();
  plan_->fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  plan_->in.resize(static_cast<std::size_t>(size));
  plan_->out.resize(static_cast<std::size_t>(bins()));
}
RealFft::RealFft(RealFft&&) noexcept = default;
RealFft& RealFft::operator=(RealFft&&) noexcept = default;
RealFft::~RealFft() = default;

void RealFft::forward(std::span<const double> in, std::span<std::complex<double>> out) {
  assert(in.size() == static_cast<std::size_t>(size_) && out.size() == static_cast<std::size_t>(bins()));
  std::copy(in.begin(), in.end(), plan_->in.begin());
  const auto lines = transform();
  std::copy(lines.begin(), lines.end(), out.begin());
}

std::span<double> RealFft::input() {
  return plan_->in;
}

std::span<const std::complex<double>> RealFft::transform() {
  return transform(input());
}

std::span<const std::complex<double>> RealFft::transform(std::span<const double> in) {
  assert(in.size() == static_cast<std::size_t>(size_));
  plan_->fft.fwd(plan_->out.data(), in.data(), size_);
  return plan_->out;
}

void RealFft::transform(std::span<const double> in, std::span<BinLane> lanes) {
  const auto lines = transform(in);
  assert(lanes.size() >= 2 * ((lines.size() + kBinsOfLane - 1) / kBinsOfLane));
  part_lines(lines.data(), lines.size(), lanes.data());
}

}  // namespace roadbalance
