#include "host/recording/formats/hdf5_writer.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/recording/formats/description_json.hpp"
#include "host/recording/formats/hdf5_handle.hpp"

namespace roadbalance {
namespace {

using Handle = Hdf5Handle;

void check(herr_t result, const std::string& file) {
  if (result < 0) throw std::runtime_error("HDF5: write " + file + ": failed; is the disk full?");
}

template <typename Number>
void set_numbers(hid_t object, const char* name, hid_t type, const Number* numbers, hsize_t count) {
  const Handle space(count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Handle attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(attribute.get(), type, numbers), name);
}

void set_number(hid_t object, const char* name, double number) {
  set_numbers(object, name, H5T_NATIVE_DOUBLE, &number, 0);
}

/// The type of a text of any length, in UTF-8.
Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  check(H5Tset_size(type.get(), H5T_VARIABLE), "text");
  check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "text");
  return type;
}

void set_text(hid_t object, const char* name, const std::string& text) {
  const Handle type = text_type();
  const char* characters = text.c_str();
  set_numbers(object, name, type.get(), &characters, 0);
}

/// Writes a text of any length: attributes have room for 64 kB in all.
void put_text(hid_t group, const char* name, const std::string& text) {
  const Handle type = text_type();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle set(H5Dcreate2(group, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                   H5Dclose);
  const char* characters = text.c_str();
  check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &characters), name);
}

/// A valid, unique name: a slash would begin a group.
std::string set_name(std::string name, std::set<std::string>& taken) {
  std::replace(name.begin(), name.end(), '/', '_');
  while (!taken.insert(name).second) name += "_";
  return name;
}

constexpr hsize_t kChunkRows = 1 << 14;

class Hdf5Writer final : public ExportWriter {
 public:
  Hdf5Writer(const std::filesystem::path& file, const ExportTable& table)
      : path_(file.string()), begun_(begin_hdf5()) {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // Whole chunks are written at once: a cache for each channel would only take memory.
    check(H5Pset_cache(access.get(), 0, 1, 0, 0.0), path_);
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V110), path_);
    // The file is new and this program's own; some file systems have no locks.
    (void)H5Pset_file_locking(access.get(), false, true);
    file_ = Handle(H5Fcreate(path_.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access.get()), H5Fclose);
    put_text(file_.get(), "description", description_json(table));
    put_text(file_.get(), "vehicle_toml", table.vehicle_toml);
    if (table.start_utc_us)
      set_numbers(file_.get(), "start_utc_us", H5T_NATIVE_INT64, &*table.start_utc_us, 0);
    std::set<std::string> taken{"description", "vehicle_toml"};
    for (const auto& group : table.group) begin(group, set_name(group.name, taken));
  }

  void add(std::size_t group, const ExportRows& rows) override {
    Group& to = group_[group];
    const std::size_t columns = to.counts.size();
    for (std::size_t row = 0; row < rows.rows(); ++row) {
      to.time_s.push_back(static_cast<double>(rows.time_ns[row]) * 1e-9);
      const std::int32_t* from = rows.counts.data() + row * columns;
      for (std::size_t c = 0; c < columns; ++c) to.counts[c].push_back(from[c]);
      if (to.time_s.size() == kChunkRows) write(to);
    }
  }

  void close() override {
    for (Group& group : group_) write(group);
    group_.clear();
    check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL), path_);
    check(file_.close(), path_);
  }

 private:
  struct Group {
    Handle group, time;
    std::vector<Handle> set;
    hsize_t chunk = 0;  ///< rows
    hsize_t written = 0;
    std::vector<double> time_s;                     ///< not yet written
    std::vector<std::vector<std::int32_t>> counts;  ///< [channel][row], not yet written
  };

  static hsize_t chunk_of(std::int64_t rows) { return std::min(kChunkRows, static_cast<hsize_t>(rows)); }

  Handle make_set(hid_t group, const std::string& name, hid_t type, std::int64_t rows, const void* fill) {
    const hsize_t size = static_cast<hsize_t>(rows);
    const hsize_t chunk = chunk_of(rows);
    const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_chunk(layout.get(), 1, &chunk), path_);
    if (fill != nullptr) check(H5Pset_fill_value(layout.get(), type, fill), path_);
    check(H5Pset_fill_time(layout.get(), H5D_FILL_TIME_IFSET), path_);
    return Handle(H5Dcreate2(group, name.c_str(), type, space.get(), H5P_DEFAULT, layout.get(), H5P_DEFAULT),
                  H5Dclose);
  }

  void describe(hid_t set, const ExportChannel& channel) {
    set_text(set, "units", channel.unit);
    set_number(set, "scale_factor", channel.scale);
    set_number(set, "add_offset", -channel.offset_counts * channel.scale);
    set_numbers(set, "_FillValue", H5T_NATIVE_INT32, &kMissingCounts, 1);
    set_text(set, "node", channel.node);
    set_text(set, "mount", channel.mount);
    set_numbers(set, "position_m", H5T_NATIVE_DOUBLE, channel.position_m.data(), 3);
    set_numbers(set, "direction", H5T_NATIVE_DOUBLE, channel.direction.data(), 3);
    set_number(set, "range", channel.range);
    set_number(set, "delay_s", channel.delay_s);
    set_number(set, "overload", channel.overload ? 1.0 : 0.0);
  }

  void begin(const ExportGroup& from, const std::string& name) {
    Group group;
    group.group =
        Handle(H5Gcreate2(file_.get(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    set_number(group.group.get(), "rate_hz", from.rate_hz);
    std::set<std::string> taken{"time_s"};
    group.chunk = chunk_of(from.rows);
    group.time = make_set(group.group.get(), "time_s", H5T_NATIVE_DOUBLE, from.rows, nullptr);
    set_text(group.time.get(), "units", "s");
    for (const auto& channel : from.channel) {
      group.set.push_back(make_set(group.group.get(), set_name(channel.name, taken), H5T_NATIVE_INT32,
                                   from.rows, &kMissingCounts));
      describe(group.set.back().get(), channel);
    }
    group.counts.resize(from.channel.size());
    group_.push_back(std::move(group));
  }

  /// Writes a whole chunk as it is in memory, which has the set's type already: HDF5 1.10 would lose its own
  /// copy if it could not write it.
  template <typename Number>
  void write_chunk(const Group& group, const Handle& set, std::vector<Number>& rows) {
    rows.resize(group.chunk);  // rows behind the end of a set are not visible
    check(
        H5Dwrite_chunk(set.get(), H5P_DEFAULT, 0, &group.written, group.chunk * sizeof(Number), rows.data()),
        path_);
    rows.clear();
  }

  void write(Group& group) {
    const std::size_t rows = group.time_s.size();
    if (rows == 0) return;
    write_chunk(group, group.time, group.time_s);
    for (std::size_t c = 0; c < group.counts.size(); ++c) write_chunk(group, group.set[c], group.counts[c]);
    group.written += rows;
  }

  const std::string path_;
  const herr_t begun_;
  Handle file_;
  std::vector<Group> group_;
};

}  // namespace

std::unique_ptr<ExportWriter> make_hdf5_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<Hdf5Writer>(file, table);
}

}  // namespace roadbalance
