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

/// A WAV file's comment, and the file for libsndfile to read, which sees nothing of it but its header, what
/// its samples are like, and these: sf_open() of libsndfile 1.2.0 does not return from some damaged lists,
/// wherever they stand.  All other chunks have the name of those that are skipped.
class WavChunks {
 public:
  /// @throws ConfigError  naming byte and chunk: one before the samples reaches beyond the file or its list
  explicit WavChunks(std::shared_ptr<const File> file);
  WavChunks(const WavChunks&) = delete;
  WavChunks& operator=(const WavChunks&) = delete;

  /// The first INFO ICMT before the samples; nothing if there is none.
  const std::optional<WavComment>& comment() const { return comment_; }

  /// As sf_open() to read; what it gives lives no longer than this.
  SNDFILE* open(SF_INFO& info);
  /// To be asked after libsndfile has read, for which such a file only ends.
  /// @throws std::system_error  the file could not be read
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
  std::optional<std::uint64_t> data_bytes_;  ///< as RF64 says it
  std::uint64_t end_;                        ///< of the samples
  std::int64_t at_ = 0;
  std::exception_ptr failure_;
};

}  // namespace roadbalance
