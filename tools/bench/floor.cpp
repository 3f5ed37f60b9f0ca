#include <cstdio>
#include <string>

#include <fftw3.h>

#include "tools/bench/bare.hpp"
#include "tools/bench/contest.hpp"

// The floor of the chain of all programs: the same datagrams over bare UDP, the same bytes onto the disk, the
// same number of transforms by FFTW.  CPU seconds of each as a line of JSON.

namespace roadbalance::bench {
namespace {

constexpr std::size_t kDatagram = 1376;  // bytes of a block of scans; with the headers of IP and UDP 1404
constexpr int kSegment = 4096;

struct Load {
  std::string file;  ///< is written and removed
  int datagrams;
  std::uintmax_t bytes;
  int transforms;
};

constexpr std::size_t kTurn = 4 << 20;  // as `dd bs=4M oflag=dsync`

double cpu_s_of(auto&& work) {
  const double begin = cpu_now_s();
  work();
  return cpu_now_s() - begin;
}

void transform(int times) {
  double* const in = fftw_alloc_real(kSegment);
  fftw_complex* const out = fftw_alloc_complex(kSegment / 2 + 1);
  fftw_plan plan = fftw_plan_dft_r2c_1d(kSegment, in, out, FFTW_ESTIMATE);  // as the product plans
  for (int n = 0; n < kSegment; ++n) in[n] = n % 7;
  for (int n = 0; n < times; ++n) fftw_execute(plan);
  fftw_destroy_plan(plan);
  fftw_free(in);
  fftw_free(out);
}

void run(const Load& load) {
  BareUdp udp(kDatagram);
  const double udp_s = cpu_s_of([&] {
    for (int sent = 0; sent < load.datagrams; sent += kMostBurst)
      udp.burst(std::min(kMostBurst, load.datagrams - sent));
  });
  const double disk_s = cpu_s_of([&] { write_bare(load.bytes, kTurn, load.file); });
  std::filesystem::remove(load.file);
  const double transforms_s = cpu_s_of([&] { transform(load.transforms); });
  std::puts(
      nlohmann::json{{"udp_s", udp_s}, {"disk_s", disk_s}, {"transforms_s", transforms_s}}.dump().c_str());
}

}  // namespace
}  // namespace roadbalance::bench

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fputs("usage: bench-floor FILE DATAGRAMS BYTES TRANSFORMS\n", stderr);
    return 2;
  }
  try {
    roadbalance::bench::run({argv[1], std::stoi(argv[2]), std::stoull(argv[3]), std::stoi(argv[4])});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench-floor: %s\n", error.what());
    return 4;
  }
}
