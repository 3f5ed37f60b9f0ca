#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/board/arm/instruction_counter.hpp"
#include "firmware/board/arm/program.hpp"
#include "firmware/board/arm/stack_mark.hpp"
#include "firmware/board/board.hpp"
#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

// Counts the instructions of the board's work in its busiest second: 10 kHz, both encoders with 1000 pulses
// and quadrature at 20 turns a second, both references at 20 kHz, CRC.
namespace roadbalance::board {
namespace {

using test::print;
using test::print_number;

constexpr std::uint32_t kScans = 10'000;
constexpr std::uint32_t kLevelsPerScan = 8;  // of each line: two teeth of four level changes
constexpr std::uint32_t kDacPerScan = 2;
constexpr std::uint32_t kTicksPerLevel = test::kTicksPerScan / kLevelsPerScan;
constexpr std::uint32_t kTeethPerTurn = 1000;

test::SimulatedHardware hardware;
[[gnu::section(".board_ram")]] std::array<std::uint8_t, kTransferBytes> packet;
alignas(Board) [[gnu::section(".board_ram")]] std::array<std::byte, sizeof(Board)> memory;

struct Worst {
  std::uint32_t most = 0;
  std::uint64_t sum = 0;
  void take(std::uint32_t count) {
    most = std::max(most, count);
    sum += count;
  }
};

Configuration busiest() {
  Configuration configuration = test::test_configuration();
  configuration.filter_order = 8;
  configuration.filter_corner_hz = 1000;
  configuration.references_on = 1;
  configuration.encoder.fill({kTeethPerTurn, kQuadrature | kZeroWired});
  return configuration;
}

bool request(Board& board, Request request, std::span<const std::uint8_t> bytes) {
  const SetupPacket setup{kVendorOut, static_cast<std::uint8_t>(request), 0, 0,
                          static_cast<std::uint16_t>(bytes.size())};
  return board.control_request(setup, bytes, {}).has_value();
}

bool begin(Board& board) {
  ReferenceSetup references;
  references.wheel[0] = {.on = 1, .line = 0};
  references.wheel[1] = {.on = 1, .line = 1};
  return request(board, Request::kReferences, encode(references)) &&
         request(board, Request::kConfigure, encode(busiest())) &&
         request(board, Request::kArm, encode(Arm{1, StartMode::kMaster})) &&
         request(board, Request::kStart, encode(Start{1}));
}

// The encoders' level changes of one scan period, and the D/A's updates among them.
void pass_period(Board& board, std::uint32_t scan) {
  for (std::uint32_t k = 0; k < kLevelsPerScan; ++k) {
    const std::uint64_t ticks = std::uint64_t{scan} * test::kTicksPerScan + (k + 1) * kTicksPerLevel - 1;
    const std::uint32_t quarter = k % 4;
    const std::uint32_t tooth = scan * (kLevelsPerScan / 4) + k / 4;
    for (std::size_t line = 0; line < kLines; ++line) {
      board.line_change(line, quarter % 2 == 0 ? Signal::kA : Signal::kB, quarter < 2, ticks);
      if (tooth % kTeethPerTurn == 0 && quarter == 1) board.line_change(line, Signal::kZero, true, ticks);
    }
    if (k % (kLevelsPerScan / kDacPerScan) == 0) board.update_references(ticks + kTicksPerLevel);
  }
}

struct Counted {
  Worst interrupts;  ///< all of one scan period
  Worst idle;        ///< next_packet() without a packet
  Worst packets;
  std::uint32_t most_per_scan = 0;  ///< of a packet's instructions
  std::uint32_t number = 0;
  std::uint32_t scans = 0;
};

Counted run(Board& board) {
  arm::InstructionCounter counter;
  Counted counted;
  for (std::uint32_t scan = 0; scan < kScans; ++scan) {
    const ScanWords words = test::words_from(scan * 0x10001);
    counter.start();
    pass_period(board, scan);
    hardware.now = std::uint64_t{scan + 1} * test::kTicksPerScan;
    board.scan(words, 0, hardware.now);
    counted.interrupts.take(counter.count());

    counter.start();
    const std::size_t size = board.next_packet(packet);
    const std::uint32_t count = counter.count();
    if (size == 0) {
      counted.idle.take(count);
      continue;
    }
    const auto view = decode_packet({packet.data(), size});
    if (!view || view->header().scans == 0) continue;  // seen in the sum of scans
    counted.packets.take(count);
    counted.most_per_scan = std::max(counted.most_per_scan, count / view->header().scans + 1);
    ++counted.number;
    counted.scans += view->header().scans;
  }
  return counted;
}

void line(const char* name, std::int64_t number) {
  print(name);
  print(" ");
  print_number(number);
  print("\n");
}

// A thousand instructions must be counted as such: the figures are worth nothing without `-icount shift=6`.
bool counts_exactly() {
  arm::InstructionCounter counter;
  counter.start();
  asm volatile(".rept 1000\n nop\n .endr");
  const std::uint32_t count = counter.count();
  if (count >= 995 && count <= 1005) return true;
  line("the counter is not QEMU's with -icount shift=6: 1000 instructions are", count);
  return false;
}

int report() {
  if (!counts_exactly()) return 1;
  Board& board = *new (memory.data()) Board(test::test_identity(), hardware);
  arm::mark_stack();
  if (!begin(board)) return 1;
  const Counted counted = run(board);
  const std::uint32_t stack = arm::stack_used();
  const bool locked = hardware.codes[0] != 0 && hardware.codes[2] != 0;
  if (!locked || counted.scans + 100 < kScans || counted.number == 0) {
    print("the busiest second was not: references not locked, or scans missing\n");
    return 1;
  }
  line("board_object_bytes", sizeof(Board));
  line("stack_bytes", stack);
  line("interrupts_worst", counted.interrupts.most);
  line("interrupts_mean", static_cast<std::int64_t>(counted.interrupts.sum / kScans));
  line("idle_worst", counted.idle.most);
  line("packet_worst", counted.packets.most);
  line("packet_per_scan_worst", counted.most_per_scan);
  line("scan_worst", counted.interrupts.most + counted.idle.most + counted.most_per_scan);
  return 0;
}

}  // namespace
}  // namespace roadbalance::board

int roadbalance::board::arm::program() {
  return report();
}
