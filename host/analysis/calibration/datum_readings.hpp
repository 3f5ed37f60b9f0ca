#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The zero mark's datum (common/vehicle/conventions.md) from a wheel that is turned by hand: it is turned on
/// until its mark has fired and stands, then somebody reads at which angle its reference point is, and that
/// several times over.
///
/// The wheel stops behind the mark, not on it: by the teeth that have passed since.  The place of the mark
/// between two teeth is found by their stamps.  Then a reading is good to the tooth that has not come yet,
///
///     datum = read - (teeth - 1/2 + place) pitches,   each +- pitch / sqrt(12)
///
/// and their mean to the scatter of the readings, but not less than that, over the root of their number.
/// Errors that all readings have in common (the car stands aslant) are not seen.
class DatumReadings {
 public:
  static constexpr double kFarthest_rad = 0.26;  ///< 15 degrees: a reading so far off is a mistake

  explicit DatumReadings(const EncoderConfig& config) : config_(config) {}

  /// The wheel's edges in order of time.  A single track takes every tooth for one that goes forward.
  void add(const Edge& edge);

  /// The mark has fired since the last reading, and no edge was lost since.
  bool can_read() const { return tooth_.has_value(); }
  /// Takes a reading of where the reference point stands now, and gives the datum by it.
  /// @pre can_read()
  double read(double angle_rad);
  /// Takes the last reading back.
  void undo();
  std::size_t readings() const { return datum_rad_.size(); }

  struct Datum {
    double datum_rad;    ///< -pi .. pi
    double sigma_rad;    ///< of it
    double scatter_rad;  ///< of a single reading
    double worst_rad;    ///< furthest reading from the mean, with its sign
  };
  /// The datum by two readings or more.
  std::optional<Datum> datum() const;
  /// Why the readings cannot be used, for people; empty: they can.
  std::string objection() const;

 private:
  double pitch_rad() const;
  double since_mark_pitches() const;

  const EncoderConfig config_;
  std::optional<std::int64_t> tooth_;                    ///< since the mark, those backward taken off
  std::optional<std::int64_t> last_tooth_ns_, mark_ns_;  ///< mark: until a tooth has come
  bool backward_ = false;        ///< so the last tooth went; a mark's other edge fires then
  std::optional<double> place_;  ///< pitches from that mark to the first tooth behind it
  std::vector<double> datum_rad_;
};

/// A datum as vehicle.toml holds it, degrees.
struct DatumText {
  std::string datum_deg;
  std::string datum_sigma_deg;  ///< not better than it was found, nor 0, which means unknown
};
DatumText datum_text(double datum_rad, double sigma_rad);

}  // namespace roadbalance
