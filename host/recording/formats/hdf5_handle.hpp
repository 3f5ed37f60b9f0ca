#pragma once

#include <hdf5.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace roadbalance {

/// To be called before the library is first used.  Errors become exceptions and are not printed on standard
/// error; and the library does not tidy up at the program's end, where it would take a file that could not be
/// written for sound.
inline herr_t begin_hdf5() {
  H5dont_atexit();
  return H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// The library's message on its last failed call; "" if there is none.
inline std::string hdf5_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* into) -> herr_t {
        if (depth == 0 && error->desc) *static_cast<std::string*>(into) = error->desc;
        return 0;
      },
      &reason);
  return reason;
}

/// @throws std::runtime_error with `failure` and the library's message on its last failed call
[[noreturn]] inline void fail_hdf5(const std::string& failure) {
  const std::string reason = hdf5_reason();
  throw std::runtime_error("HDF5: " + failure + (reason.empty() ? "" : " (" + reason + ")"));
}

/// An identifier of the library; closes itself.
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  /// @param failure  error message if the identifier is invalid
  Hdf5Handle(hid_t id, herr_t (*closing)(hid_t),
             const std::string& failure = "cannot make the file: is there room, and may it be written?")
      : id_(id), close_(closing) {
    if (id < 0) fail_hdf5(failure);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }
  herr_t close() { return close_(std::exchange(id_, -1)); }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

}  // namespace roadbalance
