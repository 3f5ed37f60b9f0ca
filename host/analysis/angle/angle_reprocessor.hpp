#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/angle/reference_filter.hpp"
#include "common/angle/steering_track.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "host/analysis/angle/edge_memory.hpp"
#include "host/analysis/angle/recorded_angle.hpp"
#include "host/analysis/angle/recorded_counter.hpp"
#include "host/analysis/angle/recorded_speed.hpp"

namespace roadbalance {

/// The references of a recording's scans computed again, of wheels whose teeth are counted on the bus
/// (EncoderConfig::counter), and if it is wanted of those with an encoder line: from all that was recorded,
/// before and after each instant.
///
/// A drive is read twice: learn() of all its blocks, then again() of each.  Where a wheel has no zero mark,
/// or marks that contradict one another, there is no angle; but if there is none in all that was learned, it
/// can be had how far the wheel has turned, from an arbitrary origin, another in each run:
/// by its counter, by its teeth, or if it has neither by the speed on the bus.  Angles and turned
/// angles of a wheel never mix.
class AngleReprocessor {
 public:
  enum class WithoutMark { kNoAngle, kTurned };

  /// For wheels with teeth on a line and a zero mark: the references as the node computed them live, or those
  /// of its recorded edges (RecordedAngle; memory: EdgeMemory).
  enum class Teeth { kAsLive, kAgain };

  explicit AngleReprocessor(const VehicleConfig& vehicle, WithoutMark without_mark = WithoutMark::kNoAngle,
                            Teeth teeth = Teeth::kAsLive);
  AngleReprocessor(const AngleReprocessor&) = delete;
  AngleReprocessor& operator=(const AngleReprocessor&) = delete;

  /// Whether there is such a wheel; else all blocks stay as they are.
  bool wanted() const { return !wheel_.empty(); }

  /// @throws std::runtime_error if there are more edges than the machine can hold
  void learn(const SealedBlock& block);

  /// The same block; a scan block with new references and Quality bits.  Blocks of each node in sequence.
  /// The result holds until the next call.
  const SealedBlock& reprocess(const SealedBlock& block);

  /// Uncertainty of a wheel's angle.
  struct Quality {
    bool located = false;           ///< by zero marks; else there are no angles, turned ones at the most
    double sigma_rad = 0.0;         ///< of an angle, rms over the scans so far; the datum apart
    double common_sigma_rad = 0.0;  ///< of this the part that is the same all through the drive
    bool by_speed = false;          ///< the speed on the bus and the rolling radius are all there is
    std::int64_t marks = 0, marks_dropped = 0;  ///< zero marks where the most lie, and elsewhere
    std::array<int, 2> mark_counts{};           ///< of marks that name no tooth: NumberedTeeth::mark_counts
    int pulses_per_turn = 0;

    /// Evidence against the marks, for people; empty: none.
    std::string contradiction() const;
  };
  /// @param wheel  a place in VehicleConfig::wheel
  /// @pre all was learned
  /// @return nothing: it is not computed again
  std::optional<Quality> quality(int wheel);

 private:
  /// Data of a wheel in an epoch of its node.
  struct Epoch {
    std::vector<SignalSample> samples;  ///< by the bus
    std::vector<Edge> edges;            ///< of the line; where a bus counts the teeth, zero marks only
    // One of these, once it is asked for.
    std::unique_ptr<RecordedCounter> counter;
    std::unique_ptr<RecordedSpeed> speed;
    std::unique_ptr<RecordedAngle> teeth;
  };
  struct Wheel {
    const WheelConfig* config;
    std::int32_t node;
    const SignalConfig* signal;        ///< nothing: its line gives it
    std::optional<int> signal_number;  ///< likewise
    bool by_speed;
    std::map<std::int64_t, Epoch> epoch;
    double told_sigma_rad = -1.0;   ///< of the angles looked up last; negative: of none
    std::optional<bool> located{};  ///< once it is asked for
    double square = 0.0;            ///< of the angles' sigma, sum
    std::int64_t rows = 0;
  };
  struct Node {
    ReferenceFilter filter;
    std::optional<int> steering_signal;
    std::map<std::int64_t, std::vector<SignalSample>> steering;  ///< by epoch
    std::map<std::int64_t, SteeringTrack> track;
    std::int64_t epoch = 0, next_scan = -1;
    std::array<std::vector<double>, kEncoderLines> angle_rad;
  };
  void add(const WheelConfig& wheel, const NodeConfig& node, std::optional<int> signal_number, bool by_speed);
  const Epoch& made(Wheel& wheel, std::int64_t epoch);
  bool located(Wheel& wheel);
  static void count(Wheel& wheel, double sigma_rad, const ScanBlock& block);
  bool turned(Wheel& wheel, const ScanBlock& block, NodeTime from, double step_ns,
              std::span<double> angle_rad);
  bool look_up(Wheel& wheel, Node& node, const ScanBlock& block, std::vector<double>& angle_rad,
               bool& uncertain);
  void replace(ScanBlock& block, Node& node);

  VehicleConfig vehicle_;
  WithoutMark without_mark_;
  EdgeMemory memory_;
  std::vector<Wheel> wheel_;
  std::map<std::int32_t, Node> node_;
  SealedBlock out_;
};

}  // namespace roadbalance
