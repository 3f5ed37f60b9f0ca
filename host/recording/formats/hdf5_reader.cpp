#include "host/recording/formats/hdf5_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "host/recording/formats/hdf5_handle.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/separate_reader.hpp"
#include "host/recording/formats/units.hpp"

namespace roadbalance {
namespace {

constexpr hsize_t kMostHdf5Samples = hsize_t{1} << 28;  ///< 37 h at 2 kHz
constexpr std::size_t kMostHdf5Text = 256;

/// An object in a group, and the place of its description in the file.
struct Named {
  std::string name;
  haddr_t byte;
  std::string place() const {
    return byte == HADDR_UNDEF ? name : name + ", described at byte " + std::to_string(byte);
  }
};

[[noreturn]] void fail(const std::string& path, const std::string& name, const std::string& reason) {
  throw ConfigError(path + ": " + (name.empty() ? "" : name + ": ") + reason);
}

/// Each name once: with two of one name the library would open the same one for both.
std::vector<Named> all_in(hid_t group, const std::string& path) {
  std::vector<Named> all;
  const herr_t done = H5Literate_by_name(
      group, ".", H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
      [](hid_t, const char* name, const H5L_info_t* link, void* into) -> herr_t {
        const haddr_t byte = link->type == H5L_TYPE_HARD ? link->u.address : HADDR_UNDEF;
        static_cast<std::vector<Named>*>(into)->push_back({name, byte});
        return 0;
      },
      &all, H5P_DEFAULT);
  if (done < 0) fail_hdf5(path + ": what is in it cannot be listed");
  std::set<std::string> seen;
  for (const Named& named : all)
    if (!seen.insert(named.name).second) fail(path, named.name, "stands twice in its group: is damaged");
  return all;
}

/// A row of numbers in the file.
class DataSet {
 public:
  /// @param rows  required number of rows; nothing: any
  DataSet(const std::string& path, hid_t group, const Named& named, std::optional<hsize_t> rows = {})
      : path_(path),
        name_(named.name),
        set_(open(group, named, chunk_bytes(group, named))),
        space_(H5Dget_space(set_.get()), H5Sclose, path_ + ": " + named.place()) {
    const Hdf5Handle type(H5Dget_type(set_.get()), H5Tclose, path_ + ": " + named.place());
    const H5T_class_t kind = H5Tget_class(type.get());
    if (H5Sget_simple_extent_ndims(space_.get()) != 1 || (kind != H5T_INTEGER && kind != H5T_FLOAT))
      fail("allowed: a row of numbers");
    H5Sget_simple_extent_dims(space_.get(), &size_, nullptr);
    if (size_ == 0 || size_ > kMostHdf5Samples) fail(std::to_string(size_) + " numbers; allowed: 1 to 2^28");
    if (rows && size_ != *rows)
      fail(std::to_string(size_) + " samples; allowed: " + std::to_string(*rows) + " as in time_s");
    if (H5Dget_storage_size(set_.get()) == 0)
      fail(std::to_string(size_) + " numbers, but none was ever written");
  }

  hid_t get() const { return set_.get(); }
  /// The place of a part of it in the file, for an error.
  std::string place(const char* what) const { return path_ + ": " + name_ + ": " + what; }
  hsize_t size() const { return size_; }
  [[noreturn]] void fail(const std::string& reason) const { roadbalance::fail(path_, name_, reason); }
  [[noreturn]] void fail_at(hsize_t row, const std::string& reason) const {
    fail("row " + std::to_string(row) + ": " + reason);
  }

  /// Reads as many numbers as `into` has room for, from row `from` on.
  void read(hsize_t from, std::span<double> into) const {
    if (try_read(from, into)) return;
    const std::string reason = hdf5_reason();
    std::size_t at = 0;
    while (at + 1 < into.size() && try_read(from + at, into.subspan(at, 1))) ++at;
    const auto byte = byte_of(from + at);
    fail("row " + std::to_string(from + at) + " cannot be read" +
         (byte ? ", its part of the file from byte " + std::to_string(*byte) + " on is damaged" : "") +
         (reason.empty() ? "" : " (" + reason + ")"));
  }

 private:
  /// Reading a part of a chunk reads the whole from the disk; one chunk is kept while it is read, unless the
  /// chunks of another program's file are so large that they would fill the memory.
  Hdf5Handle open(hid_t group, const Named& named, std::size_t chunk) const {
    constexpr std::size_t kMost = 64 << 20, kSlots = 1;
    const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose, path_);
    H5Pset_chunk_cache(access.get(), kSlots, std::min(chunk, kMost), 1.0);
    return {H5Dopen2(group, named.name.c_str(), access.get()), H5Dclose,
            path_ + ": " + named.place() + ": is no data set"};
  }
  std::size_t chunk_bytes(hid_t group, const Named& named) const {
    const Hdf5Handle set(H5Dopen2(group, named.name.c_str(), H5P_DEFAULT), H5Dclose,
                         path_ + ": " + named.place() + ": is no data set");
    const Hdf5Handle made(H5Dget_create_plist(set.get()), H5Pclose, path_ + ": " + named.place());
    const Hdf5Handle type(H5Dget_type(set.get()), H5Tclose, path_ + ": " + named.place());
    std::array<hsize_t, H5S_MAX_RANK> rows{};
    if (H5Pget_layout(made.get()) != H5D_CHUNKED || H5Pget_chunk(made.get(), H5S_MAX_RANK, rows.data()) != 1)
      return 0;
    return rows[0] * H5Tget_size(type.get());
  }

  bool try_read(hsize_t from, std::span<double> into) const {
    const hsize_t count = into.size();
    const Hdf5Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose, path_);
    H5Sselect_hyperslab(space_.get(), H5S_SELECT_SET, &from, nullptr, &count, nullptr);
    return H5Dread(set_.get(), H5T_NATIVE_DOUBLE, memory.get(), space_.get(), H5P_DEFAULT, into.data()) >= 0;
  }
  std::optional<haddr_t> byte_of(hsize_t row) const {
    haddr_t byte = H5Dget_offset(set_.get());
    hsize_t bytes = 0;
    unsigned filters = 0;
    if (byte == HADDR_UNDEF && H5Dget_chunk_info_by_coord(set_.get(), &row, &filters, &byte, &bytes) < 0)
      return std::nullopt;
    return byte == HADDR_UNDEF ? std::nullopt : std::optional(byte);
  }

  std::string path_, name_;
  Hdf5Handle set_, space_;
  hsize_t size_ = 0;
};

/// Nothing if there is no attribute of that name.
std::optional<Hdf5Handle> attribute_if(const DataSet& set, const char* name) {
  const htri_t is_there = H5Aexists(set.get(), name);
  if (is_there < 0) fail_hdf5(set.place(name));
  if (is_there == 0) return std::nullopt;
  return Hdf5Handle(H5Aopen(set.get(), name, H5P_DEFAULT), H5Aclose, set.place(name));
}

std::optional<double> number(const DataSet& set, const char* name) {
  const auto attribute = attribute_if(set, name);
  if (!attribute) return std::nullopt;
  const Hdf5Handle space(H5Aget_space(attribute->get()), H5Sclose, set.place(name));
  double value = 0.0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 ||
      H5Aread(attribute->get(), H5T_NATIVE_DOUBLE, &value) < 0)
    set.fail(std::string(name) + ": allowed: one number");
  return value;
}

std::string text(const DataSet& set, const char* name) {
  const auto attribute = attribute_if(set, name);
  if (!attribute) return {};
  const Hdf5Handle type(H5Aget_type(attribute->get()), H5Tclose, set.place(name));
  const Hdf5Handle space(H5Aget_space(attribute->get()), H5Sclose, set.place(name));
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1)
    set.fail(std::string(name) + ": allowed: a text");
  if (H5Tis_variable_str(type.get()) > 0) {
    char* characters = nullptr;
    if (H5Aread(attribute->get(), type.get(), static_cast<void*>(&characters)) < 0 || characters == nullptr)
      set.fail(std::string(name) + ": allowed: a text");
    std::string read = characters;
    H5free_memory(characters);
    return read;
  }
  std::string fixed(std::min(H5Tget_size(type.get()), kMostHdf5Text), '\0');
  if (H5Tget_size(type.get()) > kMostHdf5Text || H5Aread(attribute->get(), type.get(), fixed.data()) < 0)
    set.fail(std::string(name) + ": allowed: a text of at most 256 bytes");
  return fixed.substr(0, fixed.find('\0'));
}

/// value = stored * scale + offset, none where stored is `fill`.
struct Channel {
  DataSet set;
  std::string unit;
  double scale = 1.0, offset = 0.0;
  std::optional<double> fill;

  explicit Channel(DataSet data) : set(std::move(data)), unit(text(set, "units")) {
    scale = number(set, "scale_factor").value_or(1.0);
    offset = number(set, "add_offset").value_or(0.0);
    if (!std::isfinite(scale) || !std::isfinite(offset))
      set.fail("scale_factor or add_offset is no number, or " + std::string(kTooLarge));
    fill = number(set, "_FillValue");
  }
};

class Hdf5Samples final : public SampleSource {
 public:
  explicit Hdf5Samples(const std::filesystem::path& path) : path_(path.string()) {
    begin_hdf5();
    static_cast<void>(open_again_and_again(path));  // throws the reason why it cannot be read
    if (H5Fis_hdf5(path_.c_str()) <= 0)
      fail(path_, "", "is no HDF5 file: its signature stands neither at byte 0 nor at 512, 1024, 2048 ...");
    // It is only read; some file systems have no locks.
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path_);
    (void)H5Pset_file_locking(access.get(), false, true);
    file_ =
        Hdf5Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, path_ + ": is damaged");
    const Hdf5Handle group = find_group();
    const std::vector<Named> all = all_in(group.get(), path_);
    const auto is_time = [](const Named& named) { return named.name == "time_s"; };
    const auto time = std::ranges::find_if(all, is_time);
    if (time == all.end()) fail(path_, "", "its group lists no time_s, though it has one: is damaged");
    time_.emplace(path_, group.get(), *time);
    for (const Named& named : all) {
      if (is_time(named)) continue;
      channel_.emplace_back(DataSet(path_, group.get(), named, time_->size()));
      in_file_.push_back({.name = named.name, .unit = channel_.back().unit});
    }
    if (in_file_.empty()) fail(path_, "", "no channel beside time_s");
  }

  const std::vector<FileChannel>& channels() const override { return in_file_; }
  double part() const override { return static_cast<double>(row_) / static_cast<double>(time_->size()); }
  void rewind() override {
    row_ = 0;
    last_s_ = kNever_s;
  }
  bool read(SampleRows& rows) override {
    rows.channels = in_file_.size();
    rows.time_s.resize(std::min<hsize_t>(kRowsAtOnce, time_->size() - row_));
    rows.value.resize(rows.rows() * rows.channels);
    if (rows.rows() == 0) return false;
    time_->read(row_, rows.time_s);
    for (std::size_t k = 0; k < rows.rows(); last_s_ = rows.time_s[k++]) {
      if (!(rows.time_s[k] >= last_s_))
        time_->fail_at(row_ + k, "is no number or goes back; allowed: never falling");
      if (!is_countable(rows.time_s[k])) time_->fail_at(row_ + k, kTooFarOff);
    }
    stored_.resize(rows.rows());
    for (std::size_t c = 0; c < channel_.size(); ++c) read_channel(c, rows);
    row_ += rows.rows();
    return true;
  }

 private:
  static constexpr double kNever_s = -std::numeric_limits<double>::infinity();

  Hdf5Handle find_group() const {
    std::vector<std::string> found;
    for (const Named& named : all_in(file_.get(), path_)) {
      const Hdf5Handle object(H5Oopen(file_.get(), named.name.c_str(), H5P_DEFAULT), H5Oclose,
                              path_ + ": " + named.place());
      if (H5Iget_type(object.get()) == H5I_GROUP && H5Lexists(object.get(), "time_s", H5P_DEFAULT) > 0)
        found.push_back(named.name);
    }
    if (found.size() == 1)
      return {H5Gopen2(file_.get(), found.front().c_str(), H5P_DEFAULT), H5Gclose,
              path_ + ": " + found.front()};
    std::string all;
    for (const auto& name : found) all += " " + name;
    fail(path_, "",
         found.empty() ? "no group with a data set time_s"
                       : "has groups of" + all + "; allowed: one, for they have no common instants");
  }

  void read_channel(std::size_t c, SampleRows& rows) {
    const Channel& channel = channel_[c];
    channel.set.read(row_, stored_);
    for (std::size_t k = 0; k < stored_.size(); ++k) {
      const bool is_there = !std::isnan(stored_[k]) && stored_[k] != channel.fill;
      const double value = stored_[k] * channel.scale + channel.offset;
      if (is_there && !std::isfinite(value)) channel.set.fail_at(row_ + k, kTooLarge);
      rows.value[k * rows.channels + c] = is_there ? value : std::numeric_limits<double>::quiet_NaN();
    }
  }

  const std::string path_;
  Hdf5Handle file_;
  std::optional<DataSet> time_;
  std::vector<Channel> channel_;
  std::vector<FileChannel> in_file_;
  std::vector<double> stored_;
  hsize_t row_ = 0;
  double last_s_ = kNever_s;
};

}  // namespace

std::unique_ptr<SampleSource> open_hdf5_samples_here(const std::filesystem::path& file) {
  return std::make_unique<Hdf5Samples>(file);
}

std::int64_t open_hdf5_objects() {
  return H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL);
}

std::unique_ptr<SampleSource> open_hdf5_samples(const std::filesystem::path& file) {
  static_cast<void>(open_again_and_again(file));  // throws the system's own error, if there is one
  return read_separately(file, open_hdf5_samples_here);
}

}  // namespace roadbalance
