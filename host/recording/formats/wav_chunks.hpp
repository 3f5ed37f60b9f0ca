#pragma once

#include <sndfile.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/record/file.hpp"

namespace roadbalance {

struct WavComment {
  std::uint64_t at;  ///< byte of the file where it begins
  std::string text;
};

/// A WAV file's comment, and the file for libsndfile to read.  libsndfile sees its header, the format of its
/// samples and the samples only: sf_open() of libsndfile 1.2.0 does not return from some damaged lists,
/// wherever they stand.  All other chunks get the name of chunks that are skipped.
class WavChunks {
 public:
  /// @throws ConfigError  naming byte and chunk: one before the samples reaches beyond the file or its list
  explicit WavChunks(std::shared_ptr<const File> file);
  WavChunks(const WavChunks&) = delete;
  WavChunks& operator=(const WavChunks&) = delete;

  /// The first INFO ICMT before the samples; nothing if there is none.
  const std::optional<WavComment>& comment() const { return comment_; }

  /// Like sf_open() for reading; the result lives no longer than this object.
  SNDFILE* open(SF_INFO& info);
  /// To be called after libsndfile has read: it takes a file that cannot be read for one that ends.
  /// @throws std::system_error  if the file could not be read
  void expect_readable() const;

 private:
  struct Chunk;
  void take(const Chunk& chunk);
  void take_list(const Chunk& list);
  std::int64_t read(std::uint8_t* to, std::int64_t bytes);
  static const SF_VIRTUAL_IO& calls();

  std::shared_ptr<const File> file_;
  std::optional<WavComment> comment_;
  std::vector<std::uint64_t> hidden_;        ///< where the names of those chunks stand
  std::optional<std::uint64_t> data_bytes_;  ///< by the header of RF64
  std::uint64_t end_;                        ///< of the samples
  std::int64_t at_ = 0;
  std::exception_ptr failure_;
};

}  // namespace roadbalance
