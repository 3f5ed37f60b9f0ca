#pragma once

namespace roadbalance {

/// A sample of a WAV file is its counts times this factor: counts of 24 bits, and a reference of 1.0, which
/// is one count more, fit into 32 bits.
inline constexpr int kWavSamplesPerCount = 128;

/// Added to the counts nearest below silence it marks a missing sample: no sample has this value.
inline constexpr int kWavMissing = 1;

}  // namespace roadbalance
