#include "common/dsp/fft.hpp"

#include <algorithm>
#include <cassert>
#include <mutex>
#include <new>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <fftw3.h>

namespace roadbalance {
namespace {

// FFTW's planner keeps one memory for all threads; only executing a plan is safe beside others.
std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

fftw_complex* complex(double* samples) {
  return reinterpret_cast<fftw_complex*>(samples);
}

}  // namespace

struct RealFft::Plan {
  explicit Plan(int size)
      : in(fftw_alloc_real(static_cast<std::size_t>(size))),
        out(fftw_alloc_complex(static_cast<std::size_t>(size / 2 + 1))) {
    const std::lock_guard lock(planner());
    // Measuring would choose an algorithm by the clock, and so other last bits from run to run.
    if (in == nullptr || out == nullptr) return;
    plan = fftw_plan_dft_r2c_1d(size, in, out, FFTW_ESTIMATE);
    if (size % (2 * kPairsTogether) != 0) return;
    in_pairs = fftw_plan_dft_1d(size / 2, complex(in), out, FFTW_FORWARD, FFTW_ESTIMATE);
    std::vector<std::complex<double>> u{
        {0.0, -0.5}};  // to the last bit, so that the mean has no imaginary part
    for (int k = 1; k < size / 4; ++k)
      u.push_back(std::polar(0.5, -std::numbers::pi * (0.5 + 2.0 * k / size)));
    turn.resize(2 * u.size() / kBinsOfLane);
    part_lines(u.data(), u.size(), turn.data());
  }
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;
  ~Plan() {
    const std::lock_guard lock(planner());
    fftw_destroy_plan(plan);
    fftw_destroy_plan(in_pairs);
    fftw_free(in);
    fftw_free(out);
  }

  double* in;
  fftw_complex* out;
  fftw_plan plan = nullptr;
  fftw_plan in_pairs = nullptr;  ///< the samples as half as many complex numbers, which is faster
  std::vector<BinLane> turn;     ///< for untangle_pairs()
};

RealFft::RealFft(int size) : size_(size) {
  if (size < 2) throw std::invalid_argument("FFT size must be at least 2");
  plan_ = std::make_unique<Plan>(size);
  if (plan_->plan == nullptr) throw std::bad_alloc();
}
RealFft::RealFft(RealFft&&) noexcept = default;
RealFft& RealFft::operator=(RealFft&&) noexcept = default;
RealFft::~RealFft() = default;

void RealFft::forward(std::span<const double> in, std::span<std::complex<double>> out) {
  assert(in.size() == static_cast<std::size_t>(size_) && out.size() == static_cast<std::size_t>(bins()));
  std::copy(in.begin(), in.end(), plan_->in);
  const auto lines = transform();
  std::copy(lines.begin(), lines.end(), out.begin());
}

std::span<double> RealFft::input() {
  return {plan_->in, static_cast<std::size_t>(size_)};
}

std::span<const std::complex<double>> RealFft::transform() {
  return transform(input());
}

std::span<const std::complex<double>> RealFft::transform(std::span<const double> in) {
  assert(in.size() == static_cast<std::size_t>(size_));
  auto* const samples = const_cast<double*>(in.data());  // FFTW leaves them as they are
  assert(fftw_alignment_of(samples) == fftw_alignment_of(plan_->in));
  fftw_execute_dft_r2c(plan_->plan, samples, plan_->out);
  // Both are two doubles, real and imaginary part, by the C++ standard and FFTW's manual.
  return {reinterpret_cast<const std::complex<double>*>(plan_->out), static_cast<std::size_t>(bins())};
}

void RealFft::transform(std::span<const double> in, std::span<BinLane> lanes) {
  assert(lanes.size() >= 2 * ((static_cast<std::size_t>(bins()) + kBinsOfLane - 1) / kBinsOfLane));
  if (plan_->in_pairs == nullptr) {
    const auto lines = transform(in);
    part_lines(lines.data(), lines.size(), lanes.data());
    return;
  }
  auto* const samples = const_cast<double*>(in.data());  // FFTW leaves them as they are
  assert(fftw_alignment_of(samples) == fftw_alignment_of(plan_->in));
  fftw_execute_dft(plan_->in_pairs, complex(samples), plan_->out);
  untangle_pairs(plan_->out[0], plan_->turn.data(), in.size() / 2, lanes.data());
}

}  // namespace roadbalance
