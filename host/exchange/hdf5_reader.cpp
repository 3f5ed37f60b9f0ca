#include "host/exchange/hdf5_reader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "common/config/section.hpp"
#include "host/exchange/hdf5_handle.hpp"
#include "host/exchange/units.hpp"

namespace roadbalance {
namespace {

constexpr hsize_t kMostSamples = hsize_t{1} << 28;  ///< 37 h at 2 kHz
constexpr std::size_t kMostText = 256;

/// Names of what lies in a group.
std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  H5Literate_by_name(
      group, ".", H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* into) -> herr_t {
        static_cast<std::vector<std::string>*>(into)->emplace_back(name);
        return 0;
      },
      &names, H5P_DEFAULT);
  return names;
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path.string()) {
    begin_hdf5();
    if (!std::filesystem::exists(path))
      throw std::system_error(ENOENT, std::generic_category(), "open " + path_);
    if (H5Fis_hdf5(path_.c_str()) <= 0) fail("", "is no HDF5 file, or damaged at its beginning");
    file_ = Hdf5Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path_ + ": is damaged");
  }

  SampleTable read() {
    const Hdf5Handle group = find_group();
    SampleTable table;
    table.time_s = read_numbers(group.get(), "time_s");
    for (std::size_t row = 0; row < table.time_s.size(); ++row)
      if (!std::isfinite(table.time_s[row]) || (row > 0 && table.time_s[row] < table.time_s[row - 1]))
        fail("time_s", "row " + std::to_string(row) + ": is no number or goes back; allowed: never falling");
    for (const std::string& name : names_in(group.get())) {
      if (name == "time_s") continue;
      table.name.push_back(name);
      table.value_si.push_back(read_channel(group.get(), name, table.time_s.size()));
    }
    if (table.name.empty()) fail("", "no channel beside time_s");
    return table;
  }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& reason) const {
    throw ConfigError(path_ + ": " + (name.empty() ? "" : name + ": ") + reason);
  }

  Hdf5Handle find_group() const {
    std::vector<std::string> found;
    for (const std::string& name : names_in(file_.get())) {
      const Hdf5Handle object(H5Oopen(file_.get(), name.c_str(), H5P_DEFAULT), H5Oclose, path_ + ": " + name);
      if (H5Iget_type(object.get()) == H5I_GROUP && H5Lexists(object.get(), "time_s", H5P_DEFAULT) > 0)
        found.push_back(name);
    }
    if (found.size() == 1)
      return {H5Gopen2(file_.get(), found.front().c_str(), H5P_DEFAULT), H5Gclose,
              path_ + ": " + found.front()};
    std::string all;
    for (const auto& name : found) all += " " + name;
    fail("", found.empty() ? "no group with a data set time_s"
                           : "has groups of" + all + "; allowed: one, for they have no common instants");
  }

  /// @param rows  as many must be there; nothing: any number
  std::vector<double> read_numbers(hid_t group, const std::string& name,
                                   std::optional<hsize_t> rows = {}) const {
    const Hdf5Handle set(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose,
                         path_ + ": " + name + ": is no data set");
    const Hdf5Handle space(H5Dget_space(set.get()), H5Sclose, path_ + ": " + name);
    const Hdf5Handle type(H5Dget_type(set.get()), H5Tclose, path_ + ": " + name);
    const H5T_class_t kind = H5Tget_class(type.get());
    hsize_t size = 0;
    if (H5Sget_simple_extent_ndims(space.get()) != 1 || (kind != H5T_INTEGER && kind != H5T_FLOAT))
      fail(name, "allowed: a row of numbers");
    H5Sget_simple_extent_dims(space.get(), &size, nullptr);
    if (size == 0 || size > kMostSamples) fail(name, std::to_string(size) + " numbers; allowed: 1 to 2^28");
    if (rows && size != *rows)
      fail(name, std::to_string(size) + " samples; allowed: " + std::to_string(*rows) + " as in time_s");
    if (H5Dget_storage_size(set.get()) == 0)
      fail(name, std::to_string(size) + " numbers, but none was ever written");
    std::vector<double> numbers(size);
    if (H5Dread(set.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0)
      fail(name, "cannot be read: the file is damaged");
    return numbers;
  }

  std::optional<double> number(hid_t set, const char* name) const {
    if (H5Aexists(set, name) <= 0) return std::nullopt;
    const Hdf5Handle attribute(H5Aopen(set, name, H5P_DEFAULT), H5Aclose, path_ + ": " + name);
    const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose, path_ + ": " + name);
    double value = 0.0;
    if (H5Sget_simple_extent_npoints(space.get()) != 1 ||
        H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value) < 0)
      fail(name, "allowed: one number");
    return value;
  }

  std::string text(hid_t set, const char* name) const {
    if (H5Aexists(set, name) <= 0) return {};
    const Hdf5Handle attribute(H5Aopen(set, name, H5P_DEFAULT), H5Aclose, path_ + ": " + name);
    const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose, path_ + ": " + name);
    const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose, path_ + ": " + name);
    if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1)
      fail(name, "allowed: a text");
    if (H5Tis_variable_str(type.get()) > 0) {
      char* characters = nullptr;
      if (H5Aread(attribute.get(), type.get(), static_cast<void*>(&characters)) < 0 || characters == nullptr)
        fail(name, "allowed: a text");
      std::string read = characters;
      H5free_memory(characters);
      return read;
    }
    std::string fixed(std::min(H5Tget_size(type.get()), kMostText), '\0');
    if (H5Tget_size(type.get()) > kMostText || H5Aread(attribute.get(), type.get(), fixed.data()) < 0)
      fail(name, "allowed: a text of at most 256 bytes");
    return fixed.substr(0, fixed.find('\0'));
  }

  std::vector<double> read_channel(hid_t group, const std::string& name, std::size_t rows) const {
    std::vector<double> values = read_numbers(group, name, rows);
    const Hdf5Handle set(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose, path_ + ": " + name);
    const std::string unit = text(set.get(), "units");
    const auto factor = unit == "1" ? std::optional(1.0) : factor_of_unit(unit);
    if (!factor) fail(name, "units \"" + unit + "\"; allowed: " + kKnownUnits);
    const double scale = number(set.get(), "scale_factor").value_or(1.0) * *factor;
    const double offset = number(set.get(), "add_offset").value_or(0.0) * *factor;
    const auto fill = number(set.get(), "_FillValue");
    for (std::size_t row = 0; row < rows; ++row) {
      double& value = values[row];
      value = fill && value == *fill ? std::numeric_limits<double>::quiet_NaN() : value * scale + offset;
      if (std::isinf(value))
        fail(name, "row " + std::to_string(row) + ": is infinite; allowed: a number, or none");
    }
    return values;
  }

  const std::string path_;
  Hdf5Handle file_;
};

}  // namespace

SampleTable read_hdf5_samples(const std::filesystem::path& file) {
  try {
    return Reader(file).read();
  } catch (const std::bad_alloc&) {
    throw ConfigError(file.string() + ": has more samples than this machine has memory for");
  }
}

}  // namespace roadbalance
