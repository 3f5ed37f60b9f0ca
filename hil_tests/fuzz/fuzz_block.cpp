#include <array>
#include <cmath>

#include "common/bus/codec.hpp"
#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance {
namespace {

using fuzz::require;

std::array<fuzz::Reached, kBlockKinds> reached{fuzz::Reached("scans"),  fuzz::Reached("edges"),
                                               fuzz::Reached("a gap"),  fuzz::Reached("metadata"),
                                               fuzz::Reached("an end"), fuzz::Reached("signals")};

using Forms = std::array<std::vector<std::uint8_t>, kBlockKinds>;

Forms make_forms() {
  std::array<SealedBlock, kBlockKinds> sealed;
  seal(ScanBlock{}, sealed[0]);
  seal(EdgeBlock{}, sealed[1]);
  seal(GapBlock{}, sealed[2]);
  seal(MetaBlock{}, sealed[3]);
  seal(EndBlock{}, sealed[4]);
  seal(SignalBlock{}, sealed[5]);
  Forms forms;
  for (std::size_t k = 0; k < sealed.size(); ++k)
    forms[k].assign(sealed[k].bytes().begin(), sealed[k].bytes().end());
  return forms;
}

template <typename Block>
SealedBlock sealed_again(const Block& block) {
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

SealedBlock decode_and_seal(const SealedBlock& block) {
  switch (block.kind) {
    case BlockKind::kScan:
      return sealed_again(decode_scan(block));
    case BlockKind::kEdge: {
      const EdgeBlock edges = decode_edge(block);
      const auto unpacked = edges.unpack();
      require(unpacked.size() == static_cast<std::size_t>(edges.edges), "a block holds the edges it says");
      for (std::size_t k = 1; k < unpacked.size(); ++k)
        require(unpacked[k - 1].time <= unpacked[k].time, "edges are in order of time");
      EdgeBlock again;
      for (const Edge& edge : unpacked) require(again.add(edge), "an edge that was unpacked can be packed");
      // Not the same codes: the time of a block that was packed is that of its first edge.
      const auto twice = again.unpack();
      require(twice.size() == unpacked.size(), "packing what was unpacked keeps every edge");
      for (std::size_t k = 0; k < twice.size(); ++k)
        require(twice[k].time == unpacked[k].time && twice[k].line == unpacked[k].line &&
                    twice[k].kind == unpacked[k].kind,
                "packing what was unpacked gives the same edges");
      return sealed_again(edges);
    }
    case BlockKind::kSignal: {
      const SignalBlock signals = decode_signal(block);
      SignalBlock again;
      for (const SignalSample& sample : signals.unpack()) {
        require(std::isfinite(sample.value) && sample.signal < kMostSignals,
                "a sample is a number of a signal");
        require(again.add(sample), "a block holds no more samples than fit");
      }
      require(again.samples == signals.samples, "a block holds the samples it says");
      return sealed_again(signals);
    }
    case BlockKind::kGap:
      return sealed_again(decode_gap(block));
    case BlockKind::kMeta:
      return sealed_again(decode_meta(block));
    case BlockKind::kEnd:
      break;
  }
  return sealed_again(decode_end(block));
}

void check(std::span<const std::uint8_t> bytes) {
  SealedBlock block;
  if (accept(bytes, block) != Refusal::kNone) return;
  require(std::equal(bytes.begin(), bytes.end(), block.bytes().begin(), block.bytes().end()),
          "an accepted block is stored as it came");
  require(block.header.scans >= 0 && block.header.first_scan >= 0 &&
              block.header.first_scan + block.header.scans <= kIndexLimit,
          "indices stay below their limit");
  const SealedBlock again = decode_and_seal(block);
  require(again.header == block.header && again.size == block.size, "the header survives");
  // Bytes of a text behind its size do not count and are not kept.
  const bool same = std::equal(again.bytes().begin(), again.bytes().end(), bytes.begin());
  require(same || block.kind == BlockKind::kMeta, "sealing what was decoded gives the same bytes");
  reached[static_cast<std::size_t>(block.kind)].count();
  SealedBlock accepted;
  require(accept(again.bytes(), accepted) == Refusal::kNone, "what is sealed is accepted");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto forms = roadbalance::make_forms();
  const std::span<const std::uint8_t> bytes(data, size);
  roadbalance::check(bytes);
  for (const auto& form : forms) roadbalance::check(roadbalance::fuzz::in_form(form, bytes));
  return 0;
}
