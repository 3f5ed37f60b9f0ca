#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "common/types/clocks.hpp"
#include "firmware/board/board.hpp"

namespace roadbalance::test {

/// A level that an encoder's wire takes.
struct LineChange {
  MachineTime time{};
  std::size_t line = 0;
  board::Signal signal = board::Signal::kA;
  bool high = false;
};

/// A bench beside the board: signals of its inputs, and properties of its parts.
struct Bench {
  std::string serial = "BENCH1";
  double oscillator_ppm = 0.0;                ///< how fast the board's timer is against this machine's clock
  MachineTime powered = MachineClock::now();  ///< when its timer began to count
  std::uint16_t major = board::kProtocolMajor;
  std::uint16_t minor = board::kProtocolMinor;
  /// When a run begins that is asked for at `asked`: not before, and soon; its conversions are `period`
  /// apart. Empty: at once.
  std::function<MachineTime(MachineTime asked, std::chrono::duration<double, std::nano> period)> begin;
  /// Words of the twelve inputs at conversion k of the run; those of the loop-back are made of the board.s
  /// references.
  std::function<board::ScanWords(std::int64_t conversion, MachineTime time)> words;
  /// After which part of a period SYNC has an edge too many behind conversion k of the run; nothing: none.
  /// May be empty.
  std::function<std::optional<double>(std::int64_t conversion)> bounces;
  /// The next level of a wire, in order of time; nothing: no more.  May be empty.
  std::function<std::optional<LineChange>()> next_change;
};

/// The real board's firmware on a bench: this is its hardware layer.  Without USB.
///
/// Time passes only in advance(): everything up to then happens, in order, each with its exact stamp.
class BenchBoard final : private board::Hardware {
 public:
  static constexpr std::uint32_t kTickHz = 10'000'000;

  explicit BenchBoard(Bench bench);

  /// Connects the board whose conversions follow this one's, by the SYNC cable; it must outlive this.
  void connect_follower(BenchBoard& follower) { follower_ = &follower; }

  void advance(MachineTime now);
  std::optional<std::size_t> control_request(const board::SetupPacket& setup,
                                             std::span<const std::uint8_t> data,
                                             std::span<std::uint8_t> reply);
  std::size_t next_packet(std::span<std::uint8_t> packet);
  void reset() { board_->reset(); }
  /// The converter stands still, though the board lives, until it has been started so many times.
  void halt_converter(int starts) { starts_to_come_ = starts; }

  /// Before this no packet can be due.
  MachineTime due() const;

  const Bench& bench() const { return bench_; }
  /// Set-up by the host.
  const board::Configuration& configuration() const { return configuration_; }
  bool running() const { return running_; }
  /// When conversion k of the present or last run is, or was.
  MachineTime conversion_time(std::int64_t k) const;

 private:
  bool configure(const board::Configuration& configuration) override;
  void start(board::StartMode mode) override;
  void stop() override { running_ = false; }
  bool level(std::size_t line, board::Signal signal) const override;
  void write_references(const std::array<std::int16_t, board::kLoopChannels>& codes) override {
    codes_ = codes;
  }
  std::uint64_t ticks() const override { return ticks_at(now_); }

  using Nanoseconds = std::chrono::duration<double, std::nano>;
  Nanoseconds tick() const;
  std::uint64_t ticks_at(MachineTime time) const;
  MachineTime time_of(std::uint64_t ticks) const;
  void change_lines(std::uint64_t until_ticks);
  void convert(MachineTime time);
  void bounce(std::uint64_t stamp);

  Bench bench_;
  std::unique_ptr<board::Board> board_;
  BenchBoard* follower_ = nullptr;
  MachineTime now_ = bench_.powered;
  board::Configuration configuration_;
  bool running_ = false;
  int starts_to_come_ = 0;  ///< until which nothing is converted
  board::StartMode mode_ = board::StartMode::kImmediate;
  std::uint64_t start_ticks_ = 0;
  std::int64_t conversions_ = 0;
  std::optional<MachineTime> unsent_since_;
  std::array<std::int16_t, board::kLoopChannels> codes_{};
  std::array<std::array<bool, 3>, board::kLines> level_{};
  std::optional<LineChange> change_;
};

}  // namespace roadbalance::test
