#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// True of the columns <wheel>_angle_sin and <wheel>_angle_cos of `rb export`: they are computed anew from
/// the pulses.
bool is_reference_column(std::string_view name);

/// Samples as other programs write them: a row of channel names, a row of units, then one row an instant.
/// First column time_s [s]; an empty cell is no sample.
/// @throws ConfigError "file:line: column: reason; allowed: ...", reading it too; std::system_error if it
///         cannot be read
std::unique_ptr<SampleSource> open_csv_samples(const std::filesystem::path& file);

/// The cells of a file's lines, split at commas, without blanks around them; lines of blanks are passed over.
class CsvLines {
 public:
  explicit CsvLines(std::shared_ptr<const File> file, LinePlace from = {}) : lines_(std::move(file), from) {}

  bool next();
  const std::vector<std::string_view>& cells() const { return cells_; }
  LinePlace place() const { return lines_.place(); }
  double part() const { return lines_.part(); }

  double number(std::size_t column, const std::string& name) const;
  /// As number(), but an empty cell is no number (NaN): there was no sample.
  double sample(std::size_t column, const std::string& name) const;
  /// Value of the first column; is_countable().
  double time_s() const;
  /// All behind the first two commas: a cell in quotes, which may hold commas and doubled quotes, or a plain
  /// one.
  std::string text_behind_two(const std::string& name) const;
  [[noreturn]] void fail(const std::string& column, const std::string& reason) const;

 private:
  LineReader lines_;
  std::vector<std::string_view> cells_;
};

/// One wheel's edge, not yet given to a node's line.
struct Pulse {
  double time_s;
  int wheel;
  EdgeKind kind;
};

/// Header time_s,wheel,kind; rows in order of time, kind one of kPulseKinds.  Never held, as samples.
/// Errors as above.
class PulseSource {
 public:
  explicit PulseSource(const std::filesystem::path& file);
  std::optional<Pulse> next();
  void rewind();

 private:
  const std::shared_ptr<const File> file_;
  CsvLines lines_;
  LinePlace first_;
  double last_s_;
};

/// A mark: the words of a person during the drive.
struct ImportedMark {
  double time_s;
  std::int64_t number;  ///< from 1 on
  std::string text;
};

/// Header time_s,number,text; rows in order of time, the text in quotes, those in it doubled.  Errors as
/// above.
std::vector<ImportedMark> read_marks(const std::filesystem::path& file);

}  // namespace roadbalance
